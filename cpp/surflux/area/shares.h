#pragma once

#include <cstdint>
#include <vector>

#include "surflux/area/effective_area.h"

namespace surflux {

// The influence functions xi_j over the disk of one surfel (D04 eq. 5), a partition of unity, as images.
struct DiskShares {
    Frame frame;                         // columns run along u, rows along v
    double extent;                       // half the side of the images: the radius of the domain
    double area;                         // the surfel's effective area
    int resolution;                      // pixels along each side
    std::vector<std::uint32_t> members;  // the surfel itself, then those that share its disk
    // One image a member, row after row; at each pixel they sum to 1. NaN outside of the disk's domain.
    std::vector<double> shares;
};

// Throws ArgumentError for an index that is no surfel's, or that of a mesh patch, which has no disk.
DiskShares area_shares(const Surfels& surfels, std::size_t index, const AreaOptions& options);

}  // namespace surflux
