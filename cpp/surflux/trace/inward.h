#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/surfels.h"

namespace surflux {

struct InwardOptions {
    int rays = 8;              // from each side of each surfel
    std::size_t smallest = 8;  // surfels of a patch; fewer are noise
    std::uint64_t seed = 0;
};

// Patches of surfels whose normals point into the body that the surfels enclose: for each surfel 0, or the number of
// its patch, 1 for the largest. Light that leaves a surfel tells: rays from its back get out where those from its front
// do not. Where neither side is seen from outside, the neighbours tell, along normals that continue each other (or
// contradict: then the opposite). Sheets seen from both sides alike are left alone, whichever way they face.
std::vector<std::uint32_t> inward_patches(const Surfels& surfels, const InwardOptions& options,
                                          const Progress& progress = {});

}  // namespace surflux
