#pragma once

#include <cstdint>
#include <vector>

#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/point_placement.h"

namespace surflux {

// Places around the points of some functions of the finest level, where the next level is wanted. `first_radius`: of
// the Poisson disks of each object's first level.
Wanted wanted_around(const MultilevelBasis& basis, const std::vector<std::uint32_t>& functions,
                     const std::vector<double>& first_radius);

}  // namespace surflux
