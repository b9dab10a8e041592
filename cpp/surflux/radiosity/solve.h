#pragma once

#include <cstddef>
#include <cstdint>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/lights/direct.h"
#include "surflux/radiosity/exchange.h"
#include "surflux/radiosity/tuning.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/compiled_scene.h"

namespace surflux {

// How light between surfels is found: for all pairs of them, closed and precise, in seconds and bytes that grow with
// the square of their number; or by rays over a refined cut through a hierarchy, nearly linear.
enum class Transport { automatic, pairs, rays };

struct SolveOptions {
    Transport transport = Transport::automatic;
    std::size_t pairs_up_to = 2000;  // surfels: so many take all pairs no longer than rays take many more
    double zeta = 0.02;              // what interpolation may leave, of the RMS of H
    bool insert = true;              // surfels where the scene's are too coarse
    std::size_t max_surfels = 0;     // with insertion; 0: as leaves_allowed() says
    double tolerance = 1e-4;         // |residual| / |right-hand side| of the linear system
    int rays = 256;  // per surfel or node: to measure what escapes and what the sky sends, or to gather by
    DirectOptions direct;
    ExchangeOptions exchange;
    std::uint64_t seed = 0;
    RefinementTuning tuning;  // of what takes rays
    Team team = {};           // of processes that share out what is expensive
};

// Radiosity of the scene's surfels (D04 section 7). The scene needs areas.
Solution solve(const CompiledScene& compiled, const SolveOptions& options, const StageProgress& progress = {});

}  // namespace surflux
