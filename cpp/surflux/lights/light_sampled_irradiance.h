#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/lights/direct.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Numbers of light samples for sources that hemisphere sampling shares by multiple importance sampling: a quarter of
// `rays`, and all where some are blocked, and no fewer than go to lights.
inline DirectOptions light_sampling_options(const DirectOptions& to_lights, int rays) {
    return {std::max(to_lights.probes, rays / 4), std::max(to_lights.rays, rays)};
}

// Next event estimation: the light-sampling part of each place's irradiance, on the shapes of `points`, by the balance
// heuristic (Veach and Guibas 1995), whose other part are cosine-distributed rays (LightSampler::found). Groups of
// lights share options.probes shadow rays; those that are lit share options.rays more, where some are blocked and some
// not.
std::vector<Rgb> light_sampled_irradiance(const Tracer& tracer, const LightSampler& lights, const SurfelPoints& points,
                                          const std::vector<Place>& places, const DirectOptions& options,
                                          std::uint64_t seed, const Progress& progress = {});

// Both parts, for emissive surfels that are sampled: cosine-distributed rays, too, where no other rays find that part.
// Groups that are lit have options.rays whether any are blocked or not.
std::vector<Rgb> emitted_irradiance(const Tracer& tracer, const LightSampler& emitters, const SurfelPoints& points,
                                    const std::vector<Place>& places, const DirectOptions& options, std::uint64_t seed,
                                    const Progress& progress = {});

}  // namespace surflux
