#include "surflux/lights/light_sampled_irradiance.h"

#include <algorithm>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/light_rays.h"
#include "surflux/lights/sample_points.h"

namespace surflux {

namespace {

constexpr std::uint64_t light_stream = 0xa13ed, cosine_stream = 0xc051e;
// Where more than one in `close_share` hemisphere rays meets an emitter, there are `closer` times as many samples.
constexpr int close_share = 16, closer = 4;

// `over_hemisphere`: the surfels, if rays over the hemisphere are to be shot here, too.
std::vector<Rgb> irradiance_of(const Surfels* over_hemisphere, const Tracer& tracer, const LightSampler& lights,
                               const SurfelPoints& points, const std::vector<Place>& places,
                               const DirectOptions& options, std::uint64_t seed, const Progress& progress) {
    std::vector<Rgb> out(places.size());
    if (lights.empty()) return out;
    parallel_blocks(
        places.size(), 16,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Ray> rays;
            LightRays light;
            std::vector<Rgb> gain;
            std::vector<Hit> hits;
            for (std::size_t k = begin; k < end; ++k) {
                const Place& place = places[k];
                EvenPoints even(4, seed + light_stream, stream_of(place));
                Random random(seed + light_stream, stream_of(place));
                int taken = 0, blocked = 0, lit = 0, met = 0;
                EvenPoints even_cosine(4, seed + cosine_stream, stream_of(place));
                const Frame frame = frame_around(place.normal);
                const auto shoot_over_hemisphere = [&](int count) {
                    rays.clear();
                    for (int r = 0; r < count; ++r) {
                        const double* u = even_cosine.next();
                        rays.push_back({{points.at(place, u[2], u[3]), place.normal, place.surfel},
                                        frame.to_world(square_to_cosine_hemisphere(u[0], u[1]))});
                    }
                    tracer.closest(rays, hits);
                    for (int r = 0; r < count; ++r) {
                        const Ray& ray = rays[static_cast<std::size_t>(r)];
                        const Hit& hit = hits[static_cast<std::size_t>(r)];
                        const Rgb found = hit.front ? lights.found_at_end(place.normal, ray.direction, hit) : Rgb{};
                        (found == Rgb{} ? blocked : met) += 1;
                        out[k] += found;
                    }
                };
                const auto take = [&](int count) {
                    if (over_hemisphere) shoot_over_hemisphere(count - taken);
                    light.clear();
                    gain.clear();
                    for (; taken < count; ++taken) {
                        const double* u = even.next();
                        const Vec3 from = points.at(place, u[2], u[3]);
                        const LightRay ray = lights.sample(from, place.normal, u[0], u[1], random.uniform());
                        if (!(ray.length > 0.0)) continue;
                        light.add({from, place.normal, place.surfel}, ray);
                        gain.push_back(ray.irradiance);
                    }
                    const std::vector<char>& arrives = light.trace(tracer);
                    for (std::size_t r = 0; r < gain.size(); ++r) {
                        (arrives[r] ? lit : blocked) += 1;
                        if (arrives[r]) out[k] += gain[r];
                    }
                };
                take(options.probes);
                // A single one that disagrees speaks for others that all missed what it found, as in direct.cpp.
                if (std::min(lit + met, blocked) > 1) take(options.rays);
                // Close to emitters there is the most light, and the largest variance.
                if (met > taken / close_share) take(closer * options.rays);
                out[k] *= 1.0 / taken;
            }
        },
        progress);
    return out;
}

}  // namespace

std::vector<Rgb> light_sampled_irradiance(const Tracer& tracer, const LightSampler& lights, const SurfelPoints& points,
                                          const std::vector<Place>& places, const DirectOptions& options,
                                          std::uint64_t seed, const Progress& progress) {
    return irradiance_of(nullptr, tracer, lights, points, places, options, seed, progress);
}

std::vector<Rgb> emitted_irradiance(const Scene& scene, const Tracer& tracer, const LightSampler& emitters,
                                    const SurfelPoints& points, const std::vector<Place>& places,
                                    const DirectOptions& options, std::uint64_t seed, const Progress& progress) {
    return irradiance_of(&scene.surfels, tracer, emitters, points, places, options, seed, progress);
}

}  // namespace surflux
