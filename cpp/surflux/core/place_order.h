#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

// The points' indices in an order in which points that coincide stand together, ascending. Coordinates are finite.
std::vector<std::uint32_t> place_order(const std::vector<Vec3>& points, const Progress& progress = {});

}  // namespace surflux
