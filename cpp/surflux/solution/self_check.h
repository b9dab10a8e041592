#pragma once

#include <cstdint>

#include "surflux/core/progress.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/tracer.h"

namespace surflux {

struct SelfCheck {
    double error = 0.0;        // relative RMS; never less than what its rays can tell
    double uncertainty = 0.0;  // standard error of `error`
    std::size_t rays = 0;
    bool is_enough() const { return uncertainty <= 0.125 * error; }
};

struct SelfCheckOptions {
    int surfels = 2000;               // checked, drawn by area
    std::size_t most_rays = 1 << 20;  // about as many are traced where the error is small
    std::uint64_t seed = 0;
};

// How far a solution is from path tracing, at some of its surfels: its own estimate of its error, of direct light and
// of all bounces. Of a patch, or piece of one, the mean is checked, of a disk the value at its centre. Two independent
// halves H' and H'' give sqrt(sum (H' - H).(H'' - H) / sum |H|^2), whose mean the rays' noise has no part in; paths are
// added until its standard error is small enough.
SelfCheck gathering_error(const Scene& scene, const Tracer& tracer, const Solution& solution,
                          const SelfCheckOptions& options, const Progress& progress = {});

// The last stage of every solver: checks what it found, and fills in its error, and error, rays and seconds of the last
// entry of its history.
void check_solution(const Scene& scene, const Tracer& tracer, std::uint64_t seed, const Progress& progress,
                    Solution& solution);

}  // namespace surflux
