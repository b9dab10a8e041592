#pragma once

#include <cstdint>

#include "surflux/core/progress.h"
#include "surflux/lights/direct.h"
#include "surflux/radiosity/exchange.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/solution.h"

namespace surflux {

struct SolveOptions {
    double tolerance = 1e-4;  // |residual| / |right-hand side| of the linear system
    int rays = 256;           // per surfel, to measure what escapes and what the sky sends
    DirectOptions direct;
    ExchangeOptions exchange;
    std::uint64_t seed = 0;
};

// Radiosity of the scene's surfels on one level, all pairs: B_i = E_i + rho_i H_i, H_i = D_i + sum_j F_ij B_j (D04
// eq. 1 in the form of D03 section 3), with F symmetric in exchange and closed. The scene needs areas.
Solution solve(const Scene& scene, const SolveOptions& options, const StageProgress& progress = {});

}  // namespace surflux
