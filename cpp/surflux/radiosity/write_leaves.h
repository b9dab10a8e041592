#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "surflux/radiosity/surfel_tree.h"
#include "surflux/solution/solution.h"

namespace surflux {

// Fills in surfels, parents, levels and radiosity of `out`, whose irradiance is there: those of the leaves, in their
// order. `level_of`: SurfelTree::level of the node that light was gathered for; asked on many threads at once.
void write_leaves(const SurfelTree& tree, const std::vector<std::uint32_t>& leaves, Solution& out,
                  const std::function<std::int32_t(std::uint32_t leaf)>& level_of);

}  // namespace surflux
