#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

struct SupportOptions {
    int neighbors = 10;  // k of L07 sec. 4.2: about as many functions of a level are not zero at a place
    // No support reaches farther. A point that few others of its level face the same way as, a lone leaf, would else
    // carry its correction across the whole object.
    double largest_radius = std::numeric_limits<double>::infinity();
    std::vector<double> largest_radii = {};  // by object, in its place
    std::vector<double> radii = {};          // by point, where they are known; else they are found
};

// The radius r_j of L07 sec. 4.2 for each point of one level: the distance to the k-th nearest point of its own object
// that faces a compatible way, n . n_j > 0. Others have no weight at each other's places, so that counting them would
// leave but half of the functions on each side of a thin plate, and holes where none reaches. Points that coincide
// count as one, and none as its own neighbour: no radius is 0 for a pile of duplicates. Where fewer than k are within
// largest_radius it is that; where that is infinite and there are only m < k such points, the distance to the last is
// scaled by sqrt(k / m), as areas go, and where there is none the radius is 0, which is no support at all.
std::vector<double> support_radii(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                                  const std::vector<std::uint32_t>& objects, const SupportOptions& options);

}  // namespace surflux
