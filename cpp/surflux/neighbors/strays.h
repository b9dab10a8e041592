#pragma once

#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

// Which of distinct places are no part of a surface:
//   - those that stand alone, four times as far from their eighth neighbour as these are from theirs (after the local
// outlier factor, Breunig and others 2000, by medians);
//   - those that float: with fewer than fifteen others, as many as a normal is estimated from, they are four times as
// far from all else as is usual there. Such a clump has no tangent plane, and its disks would reach far into the air.
// A scan may thin out with distance, and what is sparse all around is neither. None of so few as do not tell.
std::vector<char> find_strays(const std::vector<Vec3>& places, const Progress& progress = {});

}  // namespace surflux
