#pragma once

#include <cstddef>
#include <vector>

#include "surflux/area/effective_area.h"
#include "surflux/area/neighborhood.h"

namespace surflux {

// OpenGL backend of effective_areas() (D04 5.3): the area of each of the finder's disks, in their order, by the same
// quadrature as on the CPU. Each disk has a tile of a float atlas; its neighbours' weights are quads added up there by
// blending; a compute shader normalizes every texel, sums those of a tile and gives one float for it. Neighbourhoods of
// the next atlas are found while one is drawn. Throws DeviceError.
std::vector<double> atlas_areas(const NeighborhoodFinder& finder, const AreaOptions& options, const Progress& progress);

// Whether a GPU may be faster at it than so many threads with the kernels of quadrature.h.
bool atlas_may_pay(std::size_t disks, const AreaOptions& options, int threads);

}  // namespace surflux
