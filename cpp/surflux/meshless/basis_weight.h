#pragma once

#include <cstdint>

namespace surflux {

// A basis function and its value at a point p: the weight w_j(p) of L07 eq. 12 or, normalized to a partition of unity,
// its share B_j(p) of eq. 8.
struct BasisWeight {
    std::uint32_t function;
    double weight;
};

}  // namespace surflux
