#pragma once

#include <cstdint>
#include <vector>

#include "surflux/lights/glossy_lobe.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/lights/sample_points.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// What glossy places send of emissive surfels that are sampled as lights: the mean of so many light samples, of all
// of them, and as many rays along the lobe, by multiple importance sampling, as paths have them (GlossyLobe).
std::vector<Rgb> emitted_lobes(const Tracer& tracer, const LightSampler& lights, const SurfelPoints& points,
                               const std::vector<Place>& places, const std::vector<GlossyLobe>& lobes, int samples,
                               std::uint64_t seed);

}  // namespace surflux
