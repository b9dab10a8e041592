#include "surflux/lights/direct_at.h"

#include <algorithm>

#include "surflux/core/parallel.h"
#include "surflux/lights/hemisphere_row.h"
#include "surflux/lights/light_sampled_irradiance.h"

namespace surflux {

namespace {

constexpr std::uint64_t sky_stream = 0x5c7a7;

}  // namespace

std::vector<Rgb> direct_at(const Scene& scene, const Tracer& tracer, const std::vector<Vec3>& points,
                           const std::vector<Vec3>& normals, const DirectOptions& options, int rays, std::uint64_t seed,
                           const Progress& progress) {
    tracer.require_near(points);
    const SurfelPoints points_of(scene.surfels);
    std::vector<Place> places(points.size());
    parallel_for(points.size(), 64, [&](std::size_t k) {
        const Departure from = tracer.departure(points[k], normals[k]);
        places[k] = {points[k], normals[k], from.surfel, Place::point};
    });
    std::vector<Rgb> out = direct_irradiance(scene, tracer, points_of, places, options, seed, progress);
    const bool has_sky = std::any_of(scene.lights.begin(), scene.lights.end(),
                                     [](const Light& light) { return std::holds_alternative<Environment>(light); });
    if (!has_sky) return out;
    const LightSampler skies(scene, LightSampler::usual_small_emitters, LightSampler::Sources::sky);
    const std::vector<Rgb> light_sampled =
        light_sampled_irradiance(tracer, skies, points_of, places, {rays, rays}, seed, progress);
    parallel_blocks(
        places.size(), 16,
        [&](std::size_t begin, std::size_t end) {
            HemisphereRow row;
            for (std::size_t k = begin; k < end; ++k) {
                const Place& place = places[k];
                gather_row(points_of, tracer, place, rays, seed + sky_stream, row);
                Rgb found;
                for (std::size_t r = 0; r < row.rays.size(); ++r)
                    if (!row.hits[r])
                        found += skies.found(place.position, place.normal, row.rays[r].direction, row.hits[r]);
                out[k] += light_sampled[k] + found / rays;
            }
        },
        progress);
    return out;
}

}  // namespace surflux
