#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/meshless/dart_throwing.h"
#include "surflux/meshless/point_grid.h"

namespace surflux {

struct FilledPoint {
    Vec3 position;
    std::uint32_t surfel;
};

// Near-maximal Poisson disk sampling of an object: points no closer to each other, and to those in `grid`, than radius
// max(0, n . n'). They go into the grid, too.
//
// L07 throws darts one by one, uniformly over the surface, until 1000 in a row are rejected. Here the same process runs
// in windows, in parallel: the darts of a window have random priorities, and each is accepted if no accepted one of
// higher priority conflicts with it (conflict_graph.h). Accepted darts that turn out to be inside geometry are
// rejected, and those that they barred tried again. Parts of the surface that one exclusion disk covers are culled.
// How many darts there are to an area is fixed beforehand: the free area falls as their number to the power -3/2 (Feder
// 1980), and the last window ends where it is the 1/`rejections` that L07 stops at.
std::vector<FilledPoint> fill_disks(const Fill& fill, PointGrid& grid, const Progress& progress);

}  // namespace surflux
