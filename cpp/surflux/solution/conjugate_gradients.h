#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "surflux/core/progress.h"

namespace surflux {

struct LinearReport {
    int applications = 0;   // of the operator, the final check included
    double residual = 0.0;  // largest over channels of |b - A x| / |b|, computed anew at the end
};

// out = A x for interleaved channels.
using LinearOperator = std::function<void(const std::vector<double>& x, std::vector<double>& out)>;

// Solves A x = b for a symmetric positive definite A, each channel with its own steps, until every residual is at most
// `tolerance` |b|. x holds the start and the result.
LinearReport conjugate_gradients(const LinearOperator& apply, const std::vector<double>& b, std::size_t channels,
                                 double tolerance, int max_applications, std::vector<double>& x,
                                 const Progress& progress = {});

}  // namespace surflux
