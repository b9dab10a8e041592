#pragma once

#include <cstddef>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

// Tangent-disk radii that follow the density and leave no gaps between surfels (D04 section 4, after Pfister et al.
// 2000): the distance to the k-th neighbour. Where those k leave an angle of more than 120 degrees open, up to 3 k
// are taken until they close it: then the disk reaches every corner of the point's Voronoi cell, for a corner
// between two neighbours at most R away, seen 120 degrees apart, is at most R away. An angle that stays open is taken
// for a border, beyond which there is nothing to cover. Duplicates count once, and a point never counts as its own
// neighbour. A point far off all others, such as scans have, would get a disk that hides them: no radius is more than
// twice the median of its neighbours'.
std::vector<double> estimate_radii(const std::vector<Vec3>& points, std::size_t neighbors = 6,
                                   const Progress& progress = {});

}  // namespace surflux
