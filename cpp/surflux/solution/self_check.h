#pragma once

#include <cstdint>

#include "surflux/scene/scene.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// How far a solution is from gathering itself: fresh rays from up to `surfels` of its surfels gather the radiosity of
// what they meet, twice and independently, H' and H''; sqrt(sum A (H' - H).(H'' - H) / sum A |H|^2). The rays' own
// noise has no part in the mean of that product; never less than its standard error. Direct light is taken as it
// stands. The solution's surfels must be those of the scene.
double gathering_error(const Scene& scene, const Tracer& tracer, const Solution& solution, int surfels, int rays,
                       std::uint64_t seed);

}  // namespace surflux
