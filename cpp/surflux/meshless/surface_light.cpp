#include "surflux/meshless/surface_light.h"

#include "surflux/lights/aimed.h"

namespace surflux {

SurfaceLight::SurfaceLight(const Scene& scene, const Tracer& tracer, const DirectOptions& options, int aimed_rays,
                           std::uint64_t seed, const Progress& progress)
    : scene_(scene),
      tracer_(tracer),
      options_(options),
      aimed_rays_(aimed_rays),
      seed_(seed),
      points_(scene.surfels),
      all_(scene),
      emitters_(scene, LightSampler::usual_small_emitters, LightSampler::Sources::surfels),
      skies_(scene, LightSampler::usual_small_emitters, LightSampler::Sources::sky) {
    surfels_ = at(places_of(scene.surfels), progress);
}

SurfaceLight::At SurfaceLight::at(const std::vector<Place>& places, const Progress& progress) const {
    At out;
    out.lights = direct_irradiance(scene_, tracer_, points_, places, options_, seed_, progress);
    const DirectOptions aimed = aimed_options(options_, aimed_rays_);
    out.emitters = emitted_irradiance(scene_, tracer_, emitters_, points_, places, aimed, seed_, progress);
    out.sky = aimed_irradiance(tracer_, skies_, points_, places, aimed, seed_ + 1, progress);
    return out;
}

}  // namespace surflux
