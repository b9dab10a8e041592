#pragma once

#include <cstdint>
#include <vector>

#include "surflux/meshless/meshless_field.h"

namespace surflux {

// The functions of a field that a picture of it needs, whatever the camera. A function without gathered light counts
// where another one of its level has some: where none is near, the level adds nothing, and most functions of fine
// levels need not be drawn. Of the coarsest level that an object has, all are needed: they say where it is covered.
struct DrawnFunctions {
    explicit DrawnFunctions(const MeshlessField& field);

    std::vector<std::vector<std::uint32_t>> levels;
    std::vector<std::int32_t> coarsest;  // level of each object; -1 where it has none
    bool direct = false;                 // is any direct light in the basis?
    double largest = 0.0;                // channel of any value
};

}  // namespace surflux
