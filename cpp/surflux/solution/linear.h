#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace surflux {

struct LinearReport {
    int applications = 0;   // of the operator, the final check included
    double residual = 0.0;  // largest over channels of |b - A x| / |b|, computed anew at the end
};

// out = A x for interleaved channels.
using LinearOperator = std::function<void(const std::vector<double>& x, std::vector<double>& out)>;

// How far an iteration is whose residual falls by about the same factor each time.
std::size_t percent_done(double residual, double tolerance);

}  // namespace surflux
