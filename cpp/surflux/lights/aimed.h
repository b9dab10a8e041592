#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/lights/direct.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// The part of the irradiance of each place, on the shapes of `points`, that rays aimed at the sampler's lights bring,
// in balance with what rays over the hemisphere find of them (LightSampler::found): options.probes rays, and
// options.rays where some of them are blocked and some not.
std::vector<Rgb> aimed_irradiance(const Tracer& tracer, const LightSampler& lights, const SurfelPoints& points,
                                  const std::vector<Place>& places, const DirectOptions& options, std::uint64_t seed,
                                  const Progress& progress = {});

}  // namespace surflux
