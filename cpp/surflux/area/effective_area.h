#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/surfels.h"

namespace surflux {

struct AreaOptions {
    double kappa = 3.0;    // how fast a surfel's influence falls across its disk, D04 eq. 6
    int resolution = 32;   // pixels across a disk, n_x = n_y of D04 5.3
    double epsilon = 0.8;  // neighbours on the same surface have n_i . n_j above this, D04 eq. 10
};

// Effective areas of D04 eq. 4-9 (the area factor enters once, as in D03 eq. 9), by quadrature over each tangent disk.
// Surfels with triangles have the exact area of their patch and take no part in the others' disks.
std::vector<double> effective_areas(const Surfels& surfels, const AreaOptions& options, const Progress& progress = {});

}  // namespace surflux
