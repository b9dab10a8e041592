#pragma once

#include <vector>

#include "surflux/core/progress.h"
#include "surflux/solution/linear.h"

namespace surflux {

// Solves A x = b for any A by restarted GMRES (Saad and Schultz 1986), all systems in lockstep, until |b - A x| <=
// tolerance |b| in each. x holds the start and the result.
LinearReport gmres(const LinearOperator& apply, const std::vector<double>& b, const LinearSystems& systems,
                   double tolerance, int max_applications, std::vector<double>& x, const Progress& progress = {});

}  // namespace surflux
