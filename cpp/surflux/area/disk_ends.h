#pragma once

#include <vector>

#include "surflux/area/effective_area.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// Sets where disks end before their rims, as the curved areas have it (neighborhood.h): at the border of the sampling
// and at creases. With it the fronts that rays meet are the surface whose area is counted, and nothing that overhangs
// it. And which disks have no neighbours at all.
void find_disk_ends(Surfels& surfels, double epsilon = AreaOptions{}.epsilon, const Progress& progress = {});

// The same with default options, and what effective_areas() gives by them: both ask for the same neighbourhoods.
std::vector<double> find_areas_and_ends(Surfels& surfels, const Progress& progress = {});

}  // namespace surflux
