#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/meshless/point_grid.h"
#include "surflux/meshless/surface.h"
#include "surflux/meshless/tuning.h"
#include "surflux/trace/tracer.h"

namespace surflux {

struct DartOptions {
    std::vector<double> radius;  // of the exclusion disks on each object; 0 where it has no area
    std::uint64_t seed;
    const SignedDistance& region;  // where darts are thrown; if it is empty, everywhere
    MeshlessTuning tuning = {};
};

// Near-maximal Poisson disk sampling of the surfaces: points outside of geometry, no closer to each other, and to those
// `there` on the same object, than radius max(0, n . n').
//
// L07 throws darts one by one until 1000 in a row are rejected. Here they come in rounds, in parallel, and only where
// the surface is still free (after Ebeida et al. 2012, with triangles for squares): each round bisects its cells until
// they are half as long as in the one before, culls those that a single exclusion disk covers, and throws a dart on
// each of the others. Of darts in conflict the one of least priority, a random number, is accepted; the others' cells
// have new ones in the next round.
std::vector<PointGrid::Point> throw_darts(const Scene& scene, const Tracer& tracer, const Surface& surface,
                                          const std::vector<PointGrid::Point>& there, const DartOptions& options,
                                          const Progress& progress);

}  // namespace surflux
