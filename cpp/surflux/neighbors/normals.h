#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

struct NormalOptions {
    std::size_t neighbors = 16;     // points of the local fit, the point itself included
    std::optional<Vec3> viewpoint;  // orient every normal towards it (a scanner)
    std::vector<char> wanted;       // of points, or empty for all: others may have normals of the first fit alone
};

// Unit normals by a local fit (surface_normal.h), towards the viewpoint where one is given, else consistently and
// outwards (orientation.h). Once they are oriented the fit is repeated without those neighbours that face elsewhere:
// the other side of a thin sheet or of a crease. Points that coincide count once. A point that even many neighbours are
// in line with takes the normal of the nearest that has one. Needs three points that do not lie on a line.
std::vector<Vec3> estimate_normals(const std::vector<Vec3>& points, const NormalOptions& options,
                                   const Progress& progress = {});

}  // namespace surflux
