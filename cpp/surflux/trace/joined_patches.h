#pragma once

#include <cstdint>
#include <vector>

#include "surflux/neighbors/orientation.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// Pieces of meshes: a number of each surfel, the same of patches that hang together by edges, of those that `near` has
// as neighbours; what begins on a face that goes on beneath it hangs on that by nothing. A disk is a piece of its own.
std::vector<std::uint32_t> joined_patches(const Surfels& surfels, const NeighborGraph& near);

}  // namespace surflux
