#pragma once

#include <vector>

#include "surflux/core/vec.h"
#include "surflux/neighbors/disk_index.h"

namespace surflux {

// Whether points lie on the surface that disks stand for. Disks leave no gap, so that every point of the surface is
// within the radius R of one that faces about its way. Here 2 R along the disk and R off its plane are near enough: on
// curved or noisy surfaces points lie beside the planes of disks, and the quarters of a disk that insertion makes
// leave gaps; of a patch all is near that is as near to its centre as its corners. A solution knows nothing finer.
class OnSurface {
public:
    // `extents`: how far the corners of a patch are from its centre, 0 of disks; empty where all are disks.
    OnSurface(std::vector<Vec3> centers, std::vector<Vec3> normals, std::vector<double> radii,
              const std::vector<double>& extents = {});
    // 1 or 0 for each point; `facing` are unit normals.
    std::vector<char> operator()(const std::vector<Vec3>& points, const std::vector<Vec3>& facing) const;

private:
    std::vector<Vec3> centers_, normals_;
    std::vector<double> radii_, along_;
    DiskIndex disks_;
};

}  // namespace surflux
