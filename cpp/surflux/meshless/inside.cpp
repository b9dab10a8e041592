#include "surflux/meshless/inside.h"

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/sample_points.h"

namespace surflux {

namespace {

constexpr std::size_t grain = 512;

// Not Hit::front, which is false as well beyond the border of a disk that is seen from its front.
bool is_back(const Scene& scene, const Hit& hit, const Vec3& direction) {
    return hit && !hit.front && dot(scene.surfels.normals[hit.surfel], direction) > 0.0;
}

}  // namespace

std::vector<char> under_backs(const Scene& scene, const Tracer& tracer, const std::vector<Departure>& places) {
    std::vector<char> out(places.size());
    parallel_blocks(places.size(), grain, [&](std::size_t begin, std::size_t end) {
        std::vector<Ray> rays;
        std::vector<Hit> hits;
        for (std::size_t k = begin; k < end; ++k) rays.push_back({places[k], places[k].normal});
        tracer.closest(rays, hits);
        for (std::size_t k = begin; k < end; ++k) out[k] = is_back(scene, hits[k - begin], places[k].normal);
    });
    return out;
}

std::vector<char> inside_geometry(const Scene& scene, const Tracer& tracer, const std::vector<Departure>& places,
                                  std::uint64_t seed, const MeshlessTuning& tuning) {
    const double steep = tuning.steep_cosine, flat = tuning.flat_cosine;
    const int further = static_cast<int>(whole_number(tuning.further_rays));
    std::vector<char> out = under_backs(scene, tracer, places);
    parallel_blocks(places.size(), grain, [&](std::size_t begin, std::size_t end) {
        std::vector<Ray> rays;
        std::vector<Hit> hits;
        for (std::size_t k = begin; k < end; ++k) {
            if (!out[k]) continue;
            const Frame frame = frame_around(places[k].normal);
            const double turn =
                Random(seed, stream_of({places[k].position, places[k].normal, places[k].surfel})).uniform();
            for (int r = 0; r < further; ++r) {
                const double z = r < further / 2 ? steep : flat, flatness = std::sqrt(1.0 - z * z);
                const double phi = 2.0 * pi * (turn + (r + (r < further / 2 ? 0.0 : 0.5)) / (0.5 * further));
                rays.push_back({places[k], frame.to_world({flatness * std::cos(phi), flatness * std::sin(phi), z})});
            }
        }
        if (rays.empty()) return;
        tracer.closest(rays, hits);
        std::size_t at = 0;
        for (std::size_t k = begin; k < end; ++k) {
            if (!out[k]) continue;
            for (int r = 0; r < further; ++r, ++at) out[k] = out[k] && is_back(scene, hits[at], rays[at].direction);
        }
    });
    return out;
}

}  // namespace surflux
