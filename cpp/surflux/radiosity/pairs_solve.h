#pragma once

#include <cstdint>

#include "surflux/core/progress.h"
#include "surflux/radiosity/exchange.h"
#include "surflux/radiosity/lit_points.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/solution.h"

namespace surflux {

struct PairsOptions {
    double tolerance = 1e-4;  // of the linear system
    int rays = 256;           // per surfel, to measure what escapes
    ExchangeOptions exchange;
    std::uint64_t seed = 0;
};

// Radiosity on one level, all pairs of surfels: B_i = E_i + rho_i H_i, H_i = D_i + sum_j F_ij B_j (D04 eq. 1 in the
// form of D03 section 3), with F symmetric in exchange and closed. D_i is what `lit` has from lights. Fills in surfels,
// parents, irradiance, direct, timings and history of `out`.
void solve_by_pairs(const Scene& scene, const Tracer& tracer, const LitPoints& lit, const PairsOptions& options,
                    const StageProgress& progress, Solution& out);

}  // namespace surflux
