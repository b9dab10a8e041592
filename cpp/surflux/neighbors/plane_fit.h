#pragma once

#include <vector>

#include "surflux/neighbors/point_index.h"

namespace surflux {

// Unit normal of the plane fitted to the points of a group: the direction in which they spread least. Zero where they
// do not span a plane.
Vec3 plane_normal(const std::vector<Vec3>& points, const std::vector<Neighbor>& group);

}  // namespace surflux
