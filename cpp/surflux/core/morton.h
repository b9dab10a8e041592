#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

// The points' indices along a Morton curve: those next to each other in the order mostly are in space.
std::vector<std::uint32_t> morton_order(const std::vector<Vec3>& points, const Progress& progress = {});

}  // namespace surflux
