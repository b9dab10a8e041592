#pragma once

#include <cstddef>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// Tangent-disk radii that follow the density (D04 section 4, after Pfister et al. 2000): the distance to the k-th
// neighbour at a place of its own. Duplicates count once, and a point never counts as its own neighbour. A point far off
// all others, such as scans have, would get a disk that hides them: no radius is more than twice the median of those
// neighbours' distances.
std::vector<double> estimate_radii(const std::vector<Vec3>& points, std::size_t neighbors = 6);

}  // namespace surflux
