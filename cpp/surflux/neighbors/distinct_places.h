#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

struct DistinctPlaces {
    std::vector<Vec3> places;             // each once, in the order in which they first appear
    std::vector<std::uint32_t> of_point;  // for every point, the index of its place
};

// Points that coincide share a place. Scans hold piles of them (dropped returns at the origin, tiles that overlap),
// and a search that has to look past a pile costs as much as the pile is high. Needs finite coordinates.
DistinctPlaces distinct_places(const std::vector<Vec3>& points, const Progress& progress = {});

}  // namespace surflux
