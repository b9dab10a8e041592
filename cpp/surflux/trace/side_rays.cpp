#include "surflux/trace/side_rays.h"

#include <algorithm>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"

namespace surflux {

namespace {

constexpr double flattest = 0.3;  // cosine of a ray; nearer the disk it meets the rims of others

Scene as_scene(const Surfels& surfels, std::vector<Vec3> normals, bool turned) {
    Scene out;
    out.surfels = surfels;
    out.surfels.normals = std::move(normals);
    out.object.assign(surfels.size(), 0);
    for (Triangle& t : out.surfels.triangles)
        if (dot(out.surfels.normals[t.surfel], surfels.normals[t.surfel]) < 0.0) std::swap(t.b, t.c);
    if (turned) {
        for (Vec3& n : out.surfels.normals) n = -n;
        for (Triangle& t : out.surfels.triangles) std::swap(t.b, t.c);
    }
    return out;
}

}  // namespace

SideRays::SideRays(const Surfels& surfels, const std::vector<Vec3>& fronts)
    : scenes_{as_scene(surfels, fronts, false), as_scene(surfels, fronts, true)} {
    for (const std::size_t k : {0, 1}) tracers_[k] = std::make_unique<Tracer>(scenes_[k]);
}

std::vector<Met> SideRays::cast(const std::vector<std::uint32_t>& from, const std::vector<Vec3>& fronts, bool behind,
                                int rays_each, std::uint64_t seed, const Progress& progress) const {
    const auto rays = static_cast<std::size_t>(rays_each);
    std::vector<Met> out(from.size() * rays);
    parallel_blocks(
        from.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const std::uint32_t i = from[k];
                const Vec3 side = behind ? -fronts[i] : fronts[i];
                const std::size_t scene = dot(side, scenes_[0].surfels.normals[i]) < 0.0;
                const Frame frame = frame_around(side);
                EvenPoints even(2, seed, i);
                for (std::size_t r = 0; r < rays; ++r) {
                    const double* u = even.next();
                    Vec3 d = square_to_cosine_hemisphere(u[0], u[1]);
                    d.z = std::max(d.z, flattest);
                    const Ray ray{{scenes_[0].surfels.positions[i], side, i}, frame.to_world(normalized(d))};
                    const Hit hit = tracers_[scene]->closest(ray);
                    if (hit) out[k * rays + r] = {hit.surfel, dot(fronts[hit.surfel], ray.direction) < 0.0};
                }
            }
        },
        progress);
    return out;
}

}  // namespace surflux
