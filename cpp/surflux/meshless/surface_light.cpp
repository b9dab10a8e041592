#include "surflux/meshless/surface_light.h"

#include <utility>

#include "surflux/lights/light_sampled_irradiance.h"
#include "surflux/lights/sky_irradiance.h"

namespace surflux {

SurfaceLight::SurfaceLight(const Scene& scene, const Tracer& tracer, const DirectOptions& options, bool lights_in_basis,
                           int light_samples, std::uint64_t seed, const Progress& progress, Team team)
    : scene_(scene),
      tracer_(tracer),
      options_(options),
      lights_in_basis_(lights_in_basis),
      light_samples_(light_samples),
      seed_(seed),
      team_(std::move(team)),
      points_(scene.surfels),
      all_(scene, LightSampler::usual_small_emitters, LightSampler::Sources::whole_images),
      emitters_(scene, LightSampler::usual_small_emitters, LightSampler::Sources::surfels),
      skies_(scene, LightSampler::usual_small_emitters, LightSampler::Sources::constant_sky),
      sky_cells_(scene.lights) {
    const std::vector<Place> places = places_of(scene.surfels);
    direct_ = direct_at(places, progress);
    emitted_ = shared_values<Rgb>(team_, "emitted light", seed, places, [&](const std::vector<Place>& at) {
        return emitted_irradiance(scene, tracer, emitters_, points_, at, light_sampling_options(options, light_samples),
                                  seed, progress);
    });
}

std::vector<Rgb> SurfaceLight::direct_at(const std::vector<Place>& places, const Progress& progress) const {
    const int sky_rays = light_samples_ / 2;
    auto out = shared_values<Rgb>(team_, "direct light", seed_, places, [&](const std::vector<Place>& at) {
        return direct_irradiance(scene_, tracer_, points_, at, options_, seed_, progress);
    });
    auto sky = shared_values<SkyLight>(team_, "light of the sky", seed_, places, [&](const std::vector<Place>& at) {
        return sky_irradiance(tracer_, sky_cells_, points_, at, sky_rays, seed_ + 1, progress);
    });
    std::vector<double> others;
    for (std::size_t k = 0; k < places.size(); ++k)
        others.push_back(luminance(out[k] + sky[k].irradiance) - sky[k].arrived);
    refine_behind_openings(tracer_, sky_cells_, points_, places, sky_rays, others, seed_ + 1, progress, team_, sky);
    for (std::size_t k = 0; k < places.size(); ++k) out[k] += sky[k].irradiance;
    return out;
}

}  // namespace surflux
