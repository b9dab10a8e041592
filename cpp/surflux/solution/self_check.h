#pragma once

#include <cstdint>

#include "surflux/scene/scene.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/tracer.h"

namespace surflux {

struct SelfCheck {
    double error = 0.0;  // relative RMS; never less than its own standard error
    std::size_t rays = 0;
};

// How far a solution is from the light that fresh rays bring to up to `surfels` of its surfels: its own estimate of its
// error. Each ray goes on to where it meets a surface, and gathers there once more, at that very place: direct light by
// an aimed ray, and by a second ray the light of the surfel that this one meets. So it sees what is wrong with the
// exchange, and what surfels lose that hold one value where light changes across them; only what the second
// bounce meets is taken as solved. Direct light of the checked surfels themselves stands as it is. Two independent
// halves H' and H'' give sqrt(sum A (H' - H).(H'' - H) / sum A |H|^2), whose mean the rays' noise has no part in.
// The solution's surfels must be those of the scene.
SelfCheck gathering_error(const Scene& scene, const Tracer& tracer, const Solution& solution, int surfels, int rays,
                          std::uint64_t seed);

}  // namespace surflux
