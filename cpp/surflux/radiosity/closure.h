#pragma once

#include <cstddef>

#include "surflux/core/progress.h"
#include "surflux/lights/hemisphere.h"
#include "surflux/radiosity/exchange.h"

namespace surflux {

struct Closure {
    double largest_correction = 0.0;  // max_i |scale_i - 1|, near pairs' own scale apart
    double residual = 0.0;            // max_i |row_i + escape_i + absorbed_i - 1| afterwards
    double largest_shortfall = 0.0;   // max_i of what row_i lacked at the largest scale, and counts as absorbed
    std::size_t short_rows = 0;       // how many lacked anything
    int rounds = 0;                   // Newton steps
    int applications = 0;             // of the exchange
};

// Closes the exchange: finds the diagonal with which every row, plus what `hemispheres` measured to escape and to be
// absorbed, makes 1 (symmetric_scaling.h). No row is ever scaled by itself. What rows at the largest scale still lack
// counts as absorbed.
//   Rows and rays may disagree on what is lost to the sky and to back faces. Sure rows are right as far as the rays
// allow it: what they lack is what they lose, within three standard errors of what the rays found. Beyond that the
// losses of sure rows are scaled like one more column; those of disks' rows hardly, as rays know them better
// (ScalingProblem::yields).
//   Most of what rows lack is missing from their near pairs, where a disk stands for a cell of unknown shape. So these
// are scaled first, by a diagonal of their own; all other pairs yield as little to it as losses do.
Closure close(Exchange& exchange, Hemispheres& hemispheres, const Progress& progress = {}, double tolerance = 1e-7,
              const PairsTuning& tuning = {});

}  // namespace surflux
