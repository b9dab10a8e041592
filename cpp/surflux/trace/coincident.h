#pragma once

#include <cstdint>
#include <vector>

#include "surflux/scene/scene.h"

namespace surflux {

// Of surfels at the very same place.
struct Coincident {
    std::vector<std::uint32_t> twin;  // of each, the one of its object that is its back (two_sided), or Hit::none
    std::vector<char> is_copy;        // a disk that is the same as an earlier one in all that rays meet
};

Coincident find_coincident(const Scene& scene);

}  // namespace surflux
