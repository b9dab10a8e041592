#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/surfels.h"

namespace surflux {

struct InwardOptions {
    std::size_t smallest = 20;  // surfels of a patch; fewer are noise
    int rays = 8;               // from each side of a surfel that is asked
    std::uint64_t seed = 0;
    bool rooms = false;  // a sheet that closes around a body may be a room, seen from inside: rays are not asked
};

// Patches of surfels whose normals point inwards: for each surfel 0, or the number of its patch, 1 for the largest.
// Surfels that continue each other, whichever way their normals point, make a sheet (neighbors/orientation.h), and in a
// sheet two of them either face the same side or do not. Ambient visibility, the share of rays that leave the scene,
// tells which side of a closed sheet is out. An open scan is seen from both sides; there the side that most of its
// surfels face is right. So is a sheet that is its own only witness. Nothing tells a room from a body turned inside
// out: with `rooms` most of the surfels of any sheet are right.
std::vector<std::uint32_t> inward_patches(const Surfels& surfels, const InwardOptions& options,
                                          const Progress& progress = {});

}  // namespace surflux
