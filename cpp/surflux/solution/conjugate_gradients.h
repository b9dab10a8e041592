#pragma once

#include <vector>

#include "surflux/core/progress.h"
#include "surflux/solution/linear.h"

namespace surflux {

// Solves A x = b for a symmetric positive definite A, each system with its own steps, until every residual is at most
// `tolerance` |b|. x holds the start and the result.
LinearReport conjugate_gradients(const LinearOperator& apply, const std::vector<double>& b,
                                 const LinearSystems& systems, double tolerance, int max_applications,
                                 std::vector<double>& x, const Progress& progress = {});

}  // namespace surflux
