#pragma once

#include <cstdint>
#include <vector>

#include "surflux/area/effective_area.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// What Surfels::ends and Surfels::alone hold.
struct DiskEnds {
    std::vector<DiskEnd> ends;
    std::vector<std::uint32_t> alone;
};

// The half planes that clip disks as the curved areas do (neighborhood.h), at borders of the sampling and at creases:
// the surface that rays meet is the one whose area is counted, without overhang. And the disks without neighbours.
DiskEnds find_disk_ends(const Surfels& surfels, double epsilon = AreaOptions{}.epsilon, const Progress& progress = {});

// The same with default options, and what effective_areas() gives by them: both ask for the same neighbourhoods. Where
// `wanted` has a mark for each surfel, of those disks alone; the others have areas of 0.
DiskEnds find_areas_and_ends(const Surfels& surfels, std::vector<double>& areas, const std::vector<char>& wanted = {},
                             const Progress& progress = {});

}  // namespace surflux
