#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "surflux/scene/scene.h"

namespace surflux {

// The surfaces of a scene: the triangles of patches, and for each disk one that is nothing but its centre. There alone
// it is known to touch the surface, and rays that leave elsewhere may start below the next disk.
struct Surface {
    explicit Surface(const Scene& scene);

    std::vector<Triangle> triangles;  // that have an area, object by object
    std::vector<double> area;         // of each object
};

// Of a triangle of these: for a disk that of the square in it, or its effective area where that is less.
double surface_area(const Scene& scene, const Triangle& t);

// From a place on the surfaces to a region of them: 0 or less within it, outside no more than the distance to it.
// Called from many threads at once.
using SignedDistance = std::function<double(const Vec3& position, const Vec3& normal, std::uint32_t object)>;

}  // namespace surflux
