#pragma once

#include <algorithm>
#include <cstddef>

#include "surflux/core/error.h"

namespace surflux {

// Rows of an image to be drawn: all of them, unless told otherwise.
struct ImageRows {
    std::size_t first = 0, count = static_cast<std::size_t>(-1);

    // How many there are of an image of that height. Throws ArgumentError.
    std::size_t within(std::size_t height) const {
        const std::size_t found = first < height ? std::min(count, height - first) : 0;
        require(found >= 1, "rows: wanted some of ", height, ", got ", count, " from ", first, " on");
        return found;
    }
};

}  // namespace surflux
