#pragma once

#include <vector>

#include "surflux/core/progress.h"
#include "surflux/render/reach.h"
#include "surflux/scene/box_tree.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// How far off the plane of each patch lies what goes on from it: corners of triangles that touch it, as far as light
// blends with them. So far its kernel is thick: not as far as a picture hangs before a wall. Infinity of disks. `tree`:
// of the boxes of all triangles.
std::vector<float> joined_depths(const Surfels& surfels, const BoxTree& tree, const std::vector<Reach>& reach,
                                 const Progress& progress = {});

}  // namespace surflux
