#include "surflux/radiosity/lit_points.h"

#include <algorithm>

#include "surflux/lights/light_sampled_irradiance.h"

namespace surflux {

LitPoints::LitPoints(const Scene& scene, const Tracer& tracer, const SurfelTree& tree, const LightSampler* emitters,
                     const LightSampler* skies, const DirectOptions& options, int light_samples, std::uint64_t seed)
    : scene_(scene),
      tracer_(tracer),
      tree_(tree),
      sampled_emitters_(emitters),
      sampled_skies_(skies),
      options_(options),
      light_samples_(light_samples),
      seed_(seed) {}

void LitPoints::update(const Progress& progress) {
    std::vector<Place> places;
    std::vector<std::uint32_t> fresh;
    for (auto p = static_cast<std::uint32_t>(lights_.size()); p < tree_.points(); ++p) {
        places.push_back(place(tree_, p));
        fresh.push_back(p);
    }
    if (places.empty()) return;
    // Parts of patches are lit as a whole, as patches are.
    const bool first = lights_.empty();
    const Surfels parts = first ? Surfels{} : tree_.surfels_at(fresh);
    const SurfelPoints points(first ? scene_.surfels : parts);
    for (std::uint32_t k = 0; k < places.size(); ++k) {
        if (points.is_patch(k)) places[k].shape = k;
        places[k].is_part = !first;
    }
    const auto append = [](std::vector<Rgb>& to, const std::vector<Rgb>& more) {
        to.insert(to.end(), more.begin(), more.end());
    };
    // Parts are small, and there are four of them.
    const auto each = [first](int rays) { return first ? rays : std::max(1, rays / 2); };
    const DirectOptions direct{each(options_.probes), each(options_.rays)};
    std::vector<Rgb> errors;
    append(lights_, direct_irradiance(scene_, tracer_, points, places, direct, seed_, progress, &errors));
    for (const Rgb& error : errors) standard_error_.push_back(luminance(error));
    const DirectOptions samples = light_sampling_options(options_, light_samples_);
    if (sampled_emitters_ && !sampled_emitters_->empty())
        append(emitters_,
               emitted_irradiance(scene_, tracer_, *sampled_emitters_, points, places, samples, seed_, progress));
    if (sampled_skies_ && !sampled_skies_->empty())
        append(sky_, light_sampled_irradiance(tracer_, *sampled_skies_, points, places, samples, seed_ + 1, progress));
    emitters_.resize(lights_.size());
    sky_.resize(lights_.size());
}

bool LitPoints::is_grey() const {
    return surflux::is_grey(lights_) && surflux::is_grey(emitters_) && surflux::is_grey(sky_);
}

}  // namespace surflux
