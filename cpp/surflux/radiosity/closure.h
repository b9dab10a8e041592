#pragma once

#include <cstddef>

#include "surflux/core/progress.h"
#include "surflux/lights/hemisphere.h"
#include "surflux/radiosity/exchange.h"

namespace surflux {

struct Closure {
    double largest_correction = 0.0;  // max_i |scale_i - 1|
    double residual = 0.0;            // max_i |row_i + escape_i + absorbed_i - 1| afterwards
    double largest_shortfall = 0.0;   // max_i of what row_i lacked at the largest scale, and counts as absorbed
    std::size_t short_rows = 0;       // how many lacked anything
    int rounds = 0;                   // Newton steps
    int applications = 0;             // of the exchange
};

// Closes the exchange: finds the diagonal with which every row, plus what `hemispheres` measured to escape and to be
// absorbed, makes 1. No row is ever scaled by itself.
//   Rows and rays may disagree on what is lost to the sky and to back faces. Sure rows are right as far as the rays
// allow it: what they lack is what they lose, within three standard errors of what the rays found. For the rest losses
// follow scale_i as its power a_i: 1 for sure rows, as if sky and backs were two more partners in the exchange; little
// for disks, of which the rays know better. D_i of the sky goes with the losses.
//   With g_i = A_i (escape_i + absorbed_i) the diagonal d minimizes 1/2 d'Gd + sum g_i d_i^a_i / a_i - sum A_i log d_i,
// which is convex in log d: where its gradient d_i (Gd)_i + g_i d_i^a_i - A_i is zero, row i makes 1. Not every
// exchange can be closed so (surfels shut in by others that are too small for them, say), and where hardly anything was
// found for a row a large scale would only magnify its error. So d_i is at most `largest_scale`: with the bound there
// is always exactly one minimum, and no row is above 1 there. What rows at the bound still lack counts as absorbed.
// Symmetric Sinkhorn iteration (Knight, Ruiz and Ucar 2014), then projected Newton steps.
Closure close(Exchange& exchange, Hemispheres& hemispheres, const Progress& progress = {}, double tolerance = 1e-7);

}  // namespace surflux
