#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

struct NormalOptions {
    std::size_t neighbors = 16;     // points of the local plane fit, the point itself included
    std::optional<Vec3> viewpoint;  // orient every normal towards it (a scanner)
};

// Unit normals by a local plane fit. Towards the viewpoint where one is given; else oriented consistently along a
// minimum spanning tree of the neighbour graph (Hoppe et al. 1992, sec. 3.3), each component outwards: the sum of
// d . n over it is positive, d the direction from its median. (On a closed surface the integral is that of
// div d = 2 / distance over the volume.) Points that coincide count once. A point that even many neighbours are in line
// with takes the normal of the nearest that has one. Needs three points that do not lie on a line.
std::vector<Vec3> estimate_normals(const std::vector<Vec3>& points, const NormalOptions& options,
                                   const Progress& progress = {});

}  // namespace surflux
