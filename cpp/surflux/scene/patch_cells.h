#pragma once

#include <cstddef>
#include <vector>

#include "surflux/scene/surfels.h"

namespace surflux {

// Cuts a flat patch into the parts nearest to each of some points on it, as triangles; together they are the patch.
std::vector<std::vector<Triangle>> patch_cells(const Triangle* begin, const Triangle* end, const Vec3* points,
                                               std::size_t count);

}  // namespace surflux
