#pragma once

#include <cstdint>
#include <vector>

#include "surflux/scene/scene.h"

namespace surflux {

// Exact duplicates among disks, by exact position: the two sides of a two_sided sheet, and copies, which Tracer keeps
// out of Embree.
struct Coincident {
    // Of each, the opposite side at its place, of its object if it has one; or Hit::none.
    std::vector<std::uint32_t> twin;
    std::vector<char> is_copy;  // a disk that is the same as an earlier one in all that rays meet
};

Coincident find_coincident(const Scene& scene, const Progress& progress = {});

}  // namespace surflux
