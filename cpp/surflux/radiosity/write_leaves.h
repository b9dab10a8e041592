#pragma once

#include <cstdint>
#include <functional>

#include "surflux/radiosity/surfel_tree.h"
#include "surflux/solution/solution.h"

namespace surflux {

struct LeafLight {
    Rgb direct, irradiance;  // total, direct light included
    std::int32_t level;      // SurfelTree::level of the node that light was gathered for
};

// Fills in surfels, parents, levels, direct, irradiance and radiosity of `out`: those of the leaves, each surfel's
// together. `light_of` is asked on many threads at once.
void write_leaves(const SurfelTree& tree, Solution& out, const std::function<LeafLight(std::uint32_t leaf)>& light_of);

}  // namespace surflux
