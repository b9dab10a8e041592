#include "surflux/radiosity/lit_points.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "surflux/core/parallel.h"
#include "surflux/core/resize.h"
#include "surflux/lights/light_sampled_irradiance.h"

namespace surflux {

LitPoints::LitPoints(const Scene& scene, const SurfelPoints& surfels, const Tracer& tracer, const SurfelTree& tree,
                     const LightSampler* emitters, const SkyCells* sky, const DirectOptions& options, int light_samples,
                     std::uint64_t seed, Team team)
    : scene_(scene),
      surfels_(surfels),
      tracer_(tracer),
      tree_(tree),
      sampled_emitters_(emitters),
      cells_(sky),
      options_(options),
      light_samples_(light_samples),
      seed_(seed),
      team_(std::move(team)) {}

void LitPoints::update(const Progress& progress) {
    std::vector<std::uint32_t> fresh(tree_.points() - lights_.size());
    if (fresh.empty()) return;
    std::iota(fresh.begin(), fresh.end(), static_cast<std::uint32_t>(lights_.size()));
    // Parts of patches are lit as a whole, as patches are.
    const bool first = lights_.empty();
    const Surfels parts = first ? Surfels{} : tree_.surfels_at(fresh);
    const SurfelPoints points_of_parts(parts);
    const SurfelPoints& points = first ? surfels_ : points_of_parts;
    std::vector<Place> places;
    resize_with_reports(places, fresh.size(), progress);
    const auto find_place = [&](std::size_t k) {
        const auto shape = static_cast<std::uint32_t>(k);
        places[k] = place(tree_, fresh[k]);
        if (points.is_patch(shape)) places[k].shape = shape;
        places[k].is_part = !first;
    };
    parallel_for(places.size(), 1024, find_place, standing_at(0, places.size(), progress));
    Light found = team_.shares() ? shine_together(points, places, progress) : shine(points, places, progress);
    if (has_sky()) refine_sky(points, places, found, progress);
    const auto append = [](auto& to, auto&& more) {
        if (to.empty()) return void(to = std::move(more));
        to.reserve(to.size() + more.size());  // and no more: most points were there from the beginning
        to.insert(to.end(), more.begin(), more.end());
    };
    append(lights_, std::move(found.lights));
    append(emitters_, std::move(found.emitters));
    sky_.reserve(sky_.size() + found.sky.size());
    for (const SkyLight& sky : found.sky) sky_.push_back(sky.irradiance);
    append(standard_error_, std::move(found.errors));
}

LitPoints::Light LitPoints::shine(const SurfelPoints& points, const std::vector<Place>& places,
                                  const Progress& progress) const {
    const DirectOptions direct{each(options_.probes), each(options_.rays)};
    Light out;
    std::vector<Rgb> errors;
    out.lights = direct_irradiance(scene_, tracer_, points, places, direct, seed_, progress, &errors);
    out.errors.reserve(errors.size());
    for (const Rgb& error : errors) out.errors.push_back(static_cast<float>(luminance(error)));
    std::vector<Rgb>().swap(errors);
    const DirectOptions samples = light_sampling_options(options_, light_samples_);
    if (has_emitters())
        out.emitters = emitted_irradiance(tracer_, *sampled_emitters_, points, places, samples, seed_, progress);
    if (has_sky()) out.sky = sky_irradiance(tracer_, *cells_, points, places, sky_rays(), seed_ + 1, progress);
    return out;
}

void LitPoints::refine_sky(const SurfelPoints& points, const std::vector<Place>& places, Light& found,
                           const Progress& progress) const {
    std::vector<double> others(places.size());
    for (std::size_t k = 0; k < places.size(); ++k) {
        const Rgb emitted = found.emitters.empty() ? Rgb{} : found.emitters[k];
        others[k] = luminance(found.lights[k] + emitted + found.sky[k].irradiance) - found.sky[k].arrived;
    }
    refine_behind_openings(tracer_, *cells_, points, places, sky_rays(), others, seed_ + 1, progress, team_, found.sky);
    for (std::size_t k = 0; k < places.size(); ++k)
        found.errors[k] = std::hypot(found.errors[k], static_cast<float>(found.sky[k].error));
}

LitPoints::Light LitPoints::shine_together(const SurfelPoints& points, const std::vector<Place>& places,
                                           const Progress& progress) const {
    Light own, all;
    all.lights.resize(places.size());
    all.errors.resize(places.size());
    if (has_emitters()) all.emitters.resize(places.size());
    if (has_sky()) all.sky.resize(places.size());
    exchange_places(
        team_, "direct light", seed_, places,
        [&](const std::vector<Place>& mine) { own = shine(points, mine, progress); },
        [&](std::size_t first, std::size_t count, Packed& to) {
            own.for_each([&](const auto& values) {
                if (!values.empty()) to.add(values.data() + first, count);
            });
        },
        [&](std::size_t begin, std::size_t end, Unpacking& from) {
            all.for_each([&](auto& values) {
                if (!values.empty()) from.take(values.data() + begin, end - begin);
            });
        });
    return all;
}

std::vector<Rgb> LitPoints::from_emitters(const std::vector<std::uint32_t>& points) const {
    std::vector<Rgb> out;
    if (emitters_.empty()) return out;
    for (const std::uint32_t p : points) out.push_back(emitters_[p]);
    return out;
}

bool LitPoints::is_grey() const {
    return surflux::is_grey(lights_) && surflux::is_grey(emitters_) && surflux::is_grey(sky_);
}

}  // namespace surflux
