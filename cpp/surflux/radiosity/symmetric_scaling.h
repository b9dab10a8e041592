#pragma once

#include <vector>

#include "surflux/core/progress.h"
#include "surflux/solution/conjugate_gradients.h"

namespace surflux {

// A symmetric matrix G >= 0 whose rows, together with what each loses besides, are to sum to `totals`. Losses are
// estimates, too, and yield in part: they are multiplied by d_i^a_i.
struct ScalingProblem {
    std::vector<double> totals;
    std::vector<double> lost;
    std::vector<double> yields;  // a, in (0, 1]; 1: losses are scaled like one more column
    LinearOperator product;      // G x
};

struct Scaling {
    std::vector<double> scale;       // d
    std::vector<double> rows;        // d_i (G d)_i + what is lost, over the total
    std::vector<double> lost_scale;  // what losses are to be multiplied by: scale to the power of the yield
    double residual = 0.0;           // largest |row - 1| but of rows that are held
    int rounds = 0;                  // Newton steps
    int applications = 0;            // of the product
};

// The diagonal d with which d_i (G d)_i + lost_i d_i^a_i = totals_i (a the yields). It minimizes 1/2 d'Gd +
// sum lost_i d_i^a_i / a_i - sum totals_i log d_i, which is convex in log d. Not every matrix can be scaled so, and
// where a row has hardly anything a large scale would only magnify its error. So d_i is at most `largest`: with the
// bound there is always exactly one minimum, and no row is above its total there; rows at the bound are held, and may
// lack something. Symmetric Sinkhorn iteration (Knight, Ruiz and Ucar 2014), then projected Newton steps.
Scaling scale_symmetrically(const ScalingProblem& problem, double largest, double tolerance,
                            const Progress& progress = {});

}  // namespace surflux
