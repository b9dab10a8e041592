#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/meshless/point_grid.h"
#include "surflux/meshless/proposing.h"

namespace surflux {

struct FilledPoint {
    Vec3 position;
    std::uint32_t surfel;
};

// Near-maximal Poisson disk sampling of an object: points no closer to each other, and to those in `grid`, than radius
// max(0, n . n'). They go into the grid, too.
//
// L07 proposes points one by one, uniformly over the surface, until 1000 in a row fail. Here the proposals of the same
// process come in windows: as many for each area as would have come meanwhile, in an order drawn by chance, each
// accepted if no earlier one that is accepted stands in its way. Parts of the surface that lie in one disk need no
// proposals any more. The last window ends when the free area is less than the 1000th part that L07 stops at: it falls
// as the power -3/2 of the proposals (Feder 1980).
std::vector<FilledPoint> fill_disks(const Fill& fill, PointGrid& grid, const Progress& progress);

}  // namespace surflux
