#include "surflux/lights/direct_at.h"

#include <algorithm>

#include "surflux/core/parallel.h"
#include "surflux/lights/direct.h"
#include "surflux/lights/sky_irradiance.h"

namespace surflux {

std::vector<Rgb> direct_at(const Scene& scene, const Tracer& tracer, const std::vector<Vec3>& points,
                           const std::vector<Vec3>& normals, int rays, std::uint64_t seed, const Progress& progress) {
    tracer.require_near(points);
    const SurfelPoints points_of(scene.surfels);
    std::vector<Place> places(points.size());
    parallel_for(points.size(), 64, [&](std::size_t k) {
        const Departure from = tracer.departure(points[k], normals[k]);
        places[k] = {points[k], normals[k], from.surfel, Place::point};
    });
    const DirectOptions options{std::max(1, rays / 8), std::max(1, rays / 2)};
    std::vector<Rgb> out = direct_irradiance(scene, tracer, points_of, places, options, seed, progress);
    const SkyCells sky(scene.lights, SkyCells::Sources::all);
    if (sky.empty()) return out;
    const SkyLight light = refined_sky_irradiance(tracer, sky, points_of, places, rays, seed, progress);
    for (std::size_t k = 0; k < out.size(); ++k) out[k] += light.irradiance[k];
    return out;
}

}  // namespace surflux
