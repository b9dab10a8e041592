#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

// Disks that coincide and face alike, n . n' > epsilon, are one disk's worth of surface: scans pile up dropped returns
// at one place. In ascending order of their first ones; of each pile the disk of median radius stands first.
std::vector<std::vector<std::uint32_t>> find_piles(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                                                   const std::vector<double>& radii, double epsilon,
                                                   const Progress& progress = {});

}  // namespace surflux
