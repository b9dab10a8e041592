#pragma once

#include <cstdint>

#include "surflux/scene/scene.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// How far a solution is from gathering itself: fresh rays from up to `surfels` of its surfels gather the radiosity of
// what they meet; sqrt(sum A |H' - H|^2 / sum A |H|^2) over them, less the variance of the rays. Direct light is taken
// as it stands. The solution's surfels must be those of the scene.
double gathering_error(const Scene& scene, const Tracer& tracer, const Solution& solution, int surfels, int rays,
                       std::uint64_t seed);

}  // namespace surflux
