#pragma once

#include <vector>

#include "surflux/scene/surfels.h"

namespace surflux {

// How far what a surfel is drawn with reaches: a disk that closes the surface, and a kernel that blends it smoothly, an
// ellipse by its half axes.
struct Reach {
    double disk;  // 0 of patches, which are drawn as they are
    Vec3 direction;
    double along, across;
};

// Disks that reach far stick out of silhouettes and creases; where areas are known, 1.4 sqrt(S) closes the surface as
// well as R does: on random points of a sphere neither leaves a hole. Kernels of that size are smooth, where those of
// estimated radii, which just close the surface, show every surfel. The kernel of a patch has its moments of inertia:
// of a square it reaches as far as the next centre, and of a long face it is narrow, too.
std::vector<Reach> reaches(const Surfels& surfels);

}  // namespace surflux
