#pragma once

#include <vector>

#include "surflux/area/effective_area.h"
#include "surflux/area/neighborhood.h"
#include "surflux/area/quadrature.h"

namespace surflux {

// The effective area of one disk after the other, on the processor. For one thread.
class DiskIntegrator {
public:
    // `grid`, of the options' resolution, has to live as long.
    DiskIntegrator(const AreaOptions& options, const PolarGrid& grid) : options_(options), grid_(grid) {}

    // Of the disk whose neighbourhood was found for the method of the options.
    double area(const Neighborhood& around);

private:
    AreaOptions options_;
    const PolarGrid& grid_;
    std::vector<DiskTerm> terms_;
    std::vector<Sharer> sharers_;
    std::vector<float> ends_;
    std::vector<SharerEnd> sharer_ends_;
};

}  // namespace surflux
