#include "surflux/meshless/surface_light.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surflux/lights/light_sampled_irradiance.h"
#include "surflux/lights/sky_irradiance.h"

namespace surflux {

SurfaceLight::SurfaceLight(const Scene& scene, const Tracer& tracer, const DirectOptions& options, bool lights_in_basis,
                           int light_samples, const MeshlessTuning& tuning, std::uint64_t seed,
                           const Progress& progress, Team team)
    : scene_(scene),
      tracer_(tracer),
      options_(options),
      lights_in_basis_(lights_in_basis),
      light_samples_(light_samples),
      alike_(tuning.alike_lights),
      roulette_(tuning.weaker_lights),
      seed_(seed),
      team_(std::move(team)),
      points_(scene.surfels),
      all_(scene, LightSampler::usual_small_emitters, LightSampler::Sources::whole_images),
      emitters_(LightSampler::of_surfels(scene)),
      skies_(scene, LightSampler::usual_small_emitters, LightSampler::Sources::constant_sky),
      sky_cells_(scene.lights) {
    const std::vector<Place> places = places_of(scene.surfels);
    for (const Direct& of : estimate_direct(places, progress)) {
        direct_.push_back(of.irradiance);
        direct_error_.push_back(static_cast<float>(of.error));
    }
    emitted_ = shared_values<Rgb>(team_, "emitted light", seed, places, [&](const std::vector<Place>& at) {
        return emitted_irradiance(tracer, emitters_, points_, at, light_sampling_options(options, light_samples), seed,
                                  progress);
    });
}

std::vector<Rgb> SurfaceLight::direct_at(const std::vector<Place>& places, const Progress& progress) const {
    std::vector<Rgb> out;
    for (const Direct& of : estimate_direct(places, progress)) out.push_back(of.irradiance);
    return out;
}

std::vector<SurfaceLight::Direct> SurfaceLight::estimate_direct(const std::vector<Place>& places,
                                                                const Progress& progress) const {
    const int sky_rays = light_samples_ / 2;
    auto out = shared_values<Direct>(team_, "direct light", seed_, places, [&](const std::vector<Place>& at) {
        DirectOptions options = options_;
        options.dark_has_error = true;
        std::vector<Rgb> errors;
        const std::vector<Rgb> found =
            direct_irradiance(scene_, tracer_, points_, at, options, seed_, progress, &errors);
        std::vector<Direct> direct;
        for (std::size_t k = 0; k < at.size(); ++k) direct.push_back({found[k], luminance(errors[k])});
        return direct;
    });
    auto sky = shared_values<SkyLight>(team_, "light of the sky", seed_, places, [&](const std::vector<Place>& at) {
        return sky_irradiance(tracer_, sky_cells_, points_, at, sky_rays, seed_ + 1, progress);
    });
    std::vector<double> others;
    for (std::size_t k = 0; k < places.size(); ++k)
        others.push_back(luminance(out[k].irradiance + sky[k].irradiance) - sky[k].arrived);
    refine_behind_openings(tracer_, sky_cells_, points_, places, sky_rays, others, seed_ + 1, progress, team_, sky);
    for (std::size_t k = 0; k < places.size(); ++k) {
        out[k].irradiance += sky[k].irradiance;
        out[k].error = std::hypot(out[k].error, sky[k].error);
    }
    return out;
}

void SurfaceLight::towards(const Vec3& point, const Vec3& normal, const double (&u)[3], Random& random,
                           std::vector<LightRay>& out) const {
    out.clear();
    const LightSampler& lights = beside();
    if (lights.groups() <= 1) {
        out.push_back(lights.sample(point, normal, u[0], u[1], u[2]));
        return;
    }
    LightRay of[LightSampler::most_groups];
    int count = 0;
    for (int group = 0; group < lights.groups(); ++group) {
        const LightRay ray = lights.sample(point, normal, u[0], u[1], u[2], group);
        if (brightness(ray.irradiance) > 0.0) of[count++] = ray;
    }
    const auto brighter = [](const LightRay& a, const LightRay& b) {
        return brightness(a.irradiance) > brightness(b.irradiance);
    };
    std::stable_sort(of, of + count, brighter);
    for (int begin = 0, end = 0; begin < count; begin = end) {
        double all = 0.0;
        for (; end < count && brightness(of[end].irradiance) >= alike_ * brightness(of[begin].irradiance); ++end)
            all += brightness(of[end].irradiance);
        if (begin > 0 && !(random.uniform() < roulette_)) continue;
        double choice = random.uniform() * all;
        const LightRay* chosen = of + begin;
        for (; chosen + 1 < of + end && choice >= brightness(chosen->irradiance); ++chosen)
            choice -= brightness(chosen->irradiance);
        out.push_back(*chosen);
        out.back().irradiance *= all / brightness(chosen->irradiance) / (begin > 0 ? roulette_ : 1.0);
    }
}

}  // namespace surflux
