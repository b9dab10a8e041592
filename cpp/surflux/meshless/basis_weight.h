#pragma once

#include <cstdint>

namespace surflux {

// What a function counts for at a place: w_j(p) of L07 eq. 12, or its share B_j(p) of eq. 8.
struct BasisWeight {
    std::uint32_t function;
    double weight;
};

}  // namespace surflux
