#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// Where a wall stands on a flat polygon, and which of its sides has a front: that on the right as one goes there, seen
// from the front of the polygon, and that on the left.
struct WallRun {
    Vec3 from, to;
    bool right, left;
    std::uint32_t wall;
};

// Which walls close off a part of a convex polygon, together with others, as the corner of a house does of a patch: a
// region of at least so much area out of which no way leads round their ends, and where one has a front; behind backs
// alone, as in a solid, it is dark. `reach`: how far from their ends they meet others. Ascending. By a grid: a gap of
// less than a cell may be closed.
std::vector<std::uint32_t> parting_walls(const std::vector<Vec3>& polygon, const Vec3& normal,
                                         const std::vector<WallRun>& runs, double reach, double least_area);

}  // namespace surflux
