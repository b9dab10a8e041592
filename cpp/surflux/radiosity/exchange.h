#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/lights/hemisphere.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

struct ExchangeOptions {
    double epsilon = 0.8;     // same surface where n_i . n_j is above this, D04 eq. 10
    bool visibility = true;   // off: every pair sees each other
    double max_memory = 0.0;  // bytes for the exchange of all pairs; 0: three quarters of what the machine has
};

// The exchange of light between all pairs of surfels: G_ij = A_i F_ij V_ij, symmetric, G_ii >= 0, stored in full so
// that a product reads it in order. What closes it is kept apart: F_ij = scale_i G_ij scale_j / A_i.
struct Exchange {
    std::size_t size = 0;
    std::vector<float> g;  // size x size, row-major
    std::vector<double> areas;
    std::vector<double> scale;  // 1 until close() finds the diagonal
    std::size_t links = 0;      // pairs i < j that exchange anything
    std::size_t rays = 0;

    // out_i = scale_i sum_j G_ij scale_j x_j for each of `channels` interleaved channels.
    void apply(const std::vector<double>& x, std::vector<double>& out, std::size_t channels) const;
};

Exchange exchange_of_all_pairs(const Scene& scene, const Tracer* tracer, const ExchangeOptions& options,
                               std::uint64_t seed, const Progress& progress = {});

struct Closure {
    double largest_correction = 0.0;  // max_i |scale_i - 1|
    double residual = 0.0;            // max_i |row_i + escape_i + absorbed_i - 1| afterwards
    double largest_shortfall = 0.0;   // max_i of what no diagonal could find for row_i, and counts as absorbed
    int rounds = 0;                   // Newton steps
    int applications = 0;             // of the exchange
};

// Closes the exchange: finds the diagonal with which every row, plus what `hemispheres` measured to escape and to be
// absorbed, makes 1. Sky and back faces count as two more partners in the exchange, and so are scaled by the same
// scale_i (D_i of the sky included): the condition scale_i (sum_j G_ij scale_j + g_i) = A_i has one solution at most,
// because it is where the function 1/2 d'Gd + g'd - sum A_i log d_i, convex in log d, is least. A few rounds of the
// symmetric Sinkhorn iteration (Knight, Ruiz and Ucar 2014), then Newton's method. No row is ever scaled by itself.
// Where there is no solution (surfels shut in by others that are too small for them) rows are at most 1, and what they
// lack counts as absorbed.
Closure close(Exchange& exchange, Hemispheres& hemispheres, const Progress& progress = {}, double tolerance = 1e-7,
              int max_rounds = 20);

}  // namespace surflux
