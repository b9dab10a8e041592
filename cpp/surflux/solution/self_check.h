#pragma once

#include <cstdint>

#include "surflux/core/progress.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/tracer.h"

namespace surflux {

struct SelfCheck {
    double error = 0.0;  // relative RMS; never less than its own standard error
    std::size_t rays = 0;
};

// How far a solution is from the light that fresh rays bring to `surfels` of the scene's surfels, drawn by area: its
// own estimate of its error. Each ray goes on to where it meets a surface, and gathers there once more, at that very
// place: direct light by an aimed ray, and by a second ray the light of the surfel that this one meets. So it sees what
// is wrong with the exchange, and what surfels lose that hold one value where light changes across them; only what the
// second bounce meets is taken as solved. Direct light of the checked surfels themselves stands as it is. Two
// independent halves H' and H'' give sqrt(sum (H' - H).(H'' - H) / sum |H|^2), whose mean the rays' noise has no part
// in. Of a surfel that was split the mean is checked.
SelfCheck gathering_error(const Scene& scene, const Tracer& tracer, const Solution& solution, int surfels, int rays,
                          std::uint64_t seed, const Progress& progress = {});

// How many of its surfels, and by how many rays twice, a solution found by rays is checked at.
constexpr int usual_checking_rays = 128;
int usual_checks(std::size_t surfels);

// The last stage of every solver: checks what it found, and fills in its error, and error, rays and seconds of the last
// entry of its history.
void check_solution(const Scene& scene, const Tracer& tracer, int surfels, int rays, std::uint64_t seed,
                    const Progress& progress, Solution& solution);

}  // namespace surflux
