#pragma once

#include <cstdint>
#include <vector>

#include "surflux/radiosity/surfel_tree.h"
#include "surflux/solution/solution.h"

namespace surflux {

// Fills in surfels, parents and radiosity of `out`, whose irradiance is there: those of the leaves, in their order.
void write_leaves(const SurfelTree& tree, const std::vector<std::uint32_t>& leaves, Solution& out,
                  const Progress& progress = {});

}  // namespace surflux
