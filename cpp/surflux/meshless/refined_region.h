#pragma once

#include <cstdint>
#include <vector>

#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/point_placement.h"

namespace surflux {

// The region to refine: where the point of one of these functions of the finest level, of the same object and facing
// alike, is within `placed_reach` Poisson radii of the level to come. `first_radius`: of the Poisson disks of each
// object's first level.
SignedDistance refined_region(const MultilevelBasis& basis, const std::vector<std::uint32_t>& functions,
                              const std::vector<double>& first_radius, double placed_reach);

// Functions of the finest level that are not zero at the points of others.
std::vector<std::uint32_t> children_of(const MultilevelBasis& basis, const std::vector<std::uint32_t>& parents);

}  // namespace surflux
