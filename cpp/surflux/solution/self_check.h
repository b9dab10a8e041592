#pragma once

#include <cstdint>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/residuals.h"
#include "surflux/solution/solution.h"
#include "surflux/solution/tuning.h"
#include "surflux/trace/tracer.h"

namespace surflux {

struct SelfCheck {
    ErrorEstimate estimate;
    std::size_t rays = 0;

    // Into those of a solution; its rays are added to what is there.
    void note_in(Figures& figures) const;
};

struct SelfCheckOptions {
    std::size_t surfels = whole_number(SelfCheckTuning{}.checked_surfels);  // drawn by area
    std::size_t most_rays = 1 << 20;  // no more rounds where another would pass this
    std::size_t most_local_rays = 0;  // the same where only errors by local light are not known yet
    std::uint64_t seed = 0;
    SelfCheckTuning tuning = {};
};

// A posteriori error of a solution, of direct light and all bounces, from its residuals at some surfels (residuals.h):
// how far it is from path tracing. Of a patch, or piece of one, the mean is checked, of a disk the value at its centre.
// Rays are added until the standard error of the estimate is small enough.
SelfCheck gathering_error(const Scene& scene, const Tracer& tracer, const Solution& solution,
                          const SelfCheckOptions& options, const Progress& progress = {}, const Team& team = {});

// The last stage of every solver: checks what it found, and fills in its error, and error, rays and seconds of the last
// entry of its history.
void check_solution(const Scene& scene, const Tracer& tracer, std::uint64_t seed, const Progress& progress,
                    Solution& solution, const Team& team = {}, const SelfCheckTuning& tuning = {});

}  // namespace surflux
