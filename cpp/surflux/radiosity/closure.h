#pragma once

#include "surflux/core/progress.h"
#include "surflux/lights/hemisphere.h"
#include "surflux/radiosity/exchange.h"

namespace surflux {

struct Closure {
    double largest_correction = 0.0;  // max_i |scale_i - 1|
    double residual = 0.0;            // max_i |row_i + escape_i + absorbed_i - 1| afterwards
    int rounds = 0;                   // Newton steps
    int applications = 0;             // of the exchange
};

// Closes the exchange: finds the diagonal with which every row, plus what `hemispheres` measured to escape and to be
// absorbed, makes 1. Sky and back faces count as two more partners in the exchange, and so are scaled by the same
// scale_i (D_i of the sky included): the condition scale_i (sum_j G_ij scale_j + g_i) = A_i has one solution, because
// it is where the function 1/2 d'Gd + g'd - sum A_i log d_i, convex in log d, is least. A few rounds of the symmetric
// Sinkhorn iteration (Knight, Ruiz and Ucar 2014), then Newton's method. No row is ever scaled by itself.
Closure close(Exchange& exchange, Hemispheres& hemispheres, const Progress& progress = {}, double tolerance = 1e-7,
              int max_rounds = 20);

}  // namespace surflux
