#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/lights/direct.h"
#include "surflux/radiosity/tuning.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/tracer.h"

namespace surflux {

struct RefinementOptions {
    double zeta = 0.02;           // difference that interpolation may leave, of the RMS of H (D04 7.1)
    bool insert = true;           // surfels where the scene's own are too coarse (D04 7.2)
    std::size_t max_surfels = 0;  // of the solution; 0: as leaves_allowed() says
    double tolerance = 1e-4;      // of the linear system
    double epsilon = 0.8;         // of the hierarchy, D04 eq. 10
    int rays = 256;               // of a node
    RefinementTuning tuning;
    DirectOptions direct;
    std::uint64_t seed = 0;
    Team team = {};
};

// Radiosity with global refinement (D04 section 7, after Stamminger, Scheel and Seidel 2000): solved on a cut through
// the hierarchy, whose nodes give way to their members until interpolation between them is good to zeta; then solved
// again from what there is, with the rays that are there already. What departs from D04:
//   - nodes hold what comes from other surfels; direct light is computed at every surfel, which also sends by itself.
// So shadows and textures refine nothing, and the cut is where the indirect light needs it to be;
//   - links are found by rays (gathering.h), so that visibility is fractional and rows make 1;
//   - fields are interpolated to first order, so that only what departs from a slope is an error.
// Fills in surfels, parents, irradiance, direct, timings and history of `out`.
void solve_by_gathering(const Scene& scene, const Tracer& tracer, const RefinementOptions& options,
                        const StageProgress& progress, Solution& out);

}  // namespace surflux
