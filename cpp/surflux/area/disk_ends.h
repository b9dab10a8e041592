#pragma once

#include <vector>

#include "surflux/area/effective_area.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// Fills in Surfels::ends, the half planes that clip disks as the curved areas do (neighborhood.h), at borders of the
// sampling and at creases: the surface that rays meet is the one whose area is counted, without overhang. Lists the
// disks without neighbours, too.
void find_disk_ends(Surfels& surfels, double epsilon = AreaOptions{}.epsilon, const Progress& progress = {});

// The same with default options, and what effective_areas() gives by them: both ask for the same neighbourhoods.
std::vector<double> find_areas_and_ends(Surfels& surfels, const Progress& progress = {});

}  // namespace surflux
