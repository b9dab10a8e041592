#pragma once

#include <vector>

namespace surflux {

// The rule of Gauss and Legendre on [0, 1]: nodes, ascending, and weights that sum to 1.
void gauss_legendre(int count, std::vector<double>& nodes, std::vector<double>& weights);

}  // namespace surflux
