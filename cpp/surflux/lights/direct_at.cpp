#include "surflux/lights/direct_at.h"

#include <algorithm>

#include "surflux/core/parallel.h"
#include "surflux/lights/direct.h"
#include "surflux/lights/light_sampled_irradiance.h"
#include "surflux/lights/sky_irradiance.h"

namespace surflux {

namespace {

std::vector<Place> places_at(const Tracer& tracer, const std::vector<Vec3>& points, const std::vector<Vec3>& normals) {
    tracer.require_near(points);
    std::vector<Place> out(points.size());
    parallel_for(points.size(), 64, [&](std::size_t k) {
        const Departure from = tracer.departure(points[k], normals[k]);
        out[k] = {points[k], normals[k], from.surfel, Place::point};
    });
    return out;
}

}  // namespace

std::vector<Rgb> direct_at(const Scene& scene, const Tracer& tracer, const std::vector<Vec3>& points,
                           const std::vector<Vec3>& normals, int rays, std::uint64_t seed, const Progress& progress) {
    const SurfelPoints points_of(scene.surfels);
    const std::vector<Place> places = places_at(tracer, points, normals);
    const DirectOptions options{std::max(1, rays / 8), std::max(1, rays / 2)};
    std::vector<Rgb> out = direct_irradiance(scene, tracer, points_of, places, options, seed, progress);
    const SkyCells sky(scene.lights, SkyCells::Sources::all);
    if (sky.empty()) return out;
    const std::vector<SkyLight> light = refined_sky_irradiance(tracer, sky, points_of, places, rays, seed, progress);
    for (std::size_t k = 0; k < out.size(); ++k) out[k] += light[k].irradiance;
    return out;
}

std::vector<Rgb> emitted_at(const Scene& scene, const Tracer& tracer, const std::vector<Vec3>& points,
                            const std::vector<Vec3>& normals, int rays, std::uint64_t seed, const Progress& progress) {
    const LightSampler emitters = LightSampler::of_surfels(scene);
    if (emitters.empty()) return std::vector<Rgb>(points.size());
    return emitted_irradiance(tracer, emitters, SurfelPoints(scene.surfels), places_at(tracer, points, normals),
                              {std::max(1, rays / 16), std::max(1, rays / 4)}, seed, progress);
}

}  // namespace surflux
