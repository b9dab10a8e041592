#include "surflux/lights/hemisphere.h"

#include <atomic>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/sample_points.h"

namespace surflux {

namespace {

constexpr int more_rays = 4;  // times as many where the first do not agree
constexpr std::uint64_t cosine_stream = 1;

}  // namespace

Hemispheres measure_hemispheres(const Scene& scene, const Tracer& tracer, int rays, std::uint64_t seed,
                                const Progress& progress) {
    const Surfels& s = scene.surfels;
    const SurfelPoints points(s);
    Hemispheres out;
    for (const Light& light : scene.lights) {
        const auto* environment = std::get_if<Environment>(&light);
        if (environment && environment->pixels.empty()) out.constant_sky += environment->radiance;
    }

    out.escape.assign(s.size(), 0.0);
    out.absorbed.assign(s.size(), 0.0);
    out.taken.assign(s.size(), 0);
    std::atomic<std::size_t> traced{0};

    const auto measure = [&](std::size_t k) {
        const auto i = static_cast<std::uint32_t>(k);
        const Frame frame = frame_around(s.normals[i]);
        EvenPoints even(points.extends(i) ? 4 : 2, seed + cosine_stream, i);
        int taken = 0, escaped = 0, absorbed = 0;
        const auto take = [&](int count) {
            for (; taken < count; ++taken) {
                const double* u = even.next();
                const Vec3 direction = frame.to_world(square_to_cosine_hemisphere(u[0], u[1]));
                const Hit hit = tracer.closest({{points.at(i, u[2], u[3]), frame.n, i}, direction});
                if (hit)
                    absorbed += !hit.front;
                else
                    ++escaped;
            }
        };
        take(rays);
        const bool agree = (escaped == 0 || escaped == taken) && (absorbed == 0 || absorbed == taken);
        if (!agree) take(more_rays * rays);
        out.escape[i] = static_cast<double>(escaped) / taken;
        out.absorbed[i] = static_cast<double>(absorbed) / taken;
        out.taken[i] = static_cast<std::uint32_t>(taken);
        traced += static_cast<std::size_t>(taken);
    };
    parallel_for(s.size(), 16, measure, progress);
    out.rays = traced;
    return out;
}

}  // namespace surflux
