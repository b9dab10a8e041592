#include "surflux/lights/aimed.h"

#include <algorithm>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/sample_points.h"

namespace surflux {

namespace {

constexpr std::uint64_t aimed_stream = 0xa13ed;

}  // namespace

std::vector<Rgb> aimed_irradiance(const Tracer& tracer, const LightSampler& lights, const SurfelPoints& points,
                                  const std::vector<Place>& places, const DirectOptions& options, std::uint64_t seed,
                                  const Progress& progress) {
    std::vector<Rgb> out(places.size());
    if (lights.empty()) return out;
    parallel_blocks(
        places.size(), 16,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Ray> rays;
            std::vector<LightRay> light;
            std::vector<Hit> hits;
            for (std::size_t k = begin; k < end; ++k) {
                const Place& place = places[k];
                EvenPoints even(4, seed + aimed_stream, stream_of(place));
                Random random(seed + aimed_stream, stream_of(place));
                int taken = 0, blocked = 0, lit = 0;
                const auto take = [&](int count) {
                    rays.clear();
                    light.clear();
                    for (; taken < count; ++taken) {
                        const double* u = even.next();
                        const Vec3 from = points.at(place, u[2], u[3]);
                        const LightRay ray = lights.sample(from, place.normal, u[0], u[1], random.uniform());
                        if (!(ray.length > 0.0)) continue;
                        rays.push_back({{from, place.normal, place.surfel}, ray.direction, ray.length});
                        light.push_back(ray);
                    }
                    tracer.closest(rays, hits);
                    for (std::size_t r = 0; r < rays.size(); ++r) {
                        const bool passes = light[r].arrives(hits[r]);
                        (passes ? lit : blocked) += 1;
                        if (passes) out[k] += light[r].irradiance;
                    }
                };
                take(options.probes);
                // A single one that disagrees speaks for others that all missed what it found, as in direct.cpp.
                if (std::min(lit, blocked) > 1) take(options.rays);
                out[k] *= 1.0 / taken;
            }
        },
        progress);
    return out;
}

}  // namespace surflux
