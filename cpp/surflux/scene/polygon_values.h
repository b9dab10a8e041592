#pragma once

#include <cstddef>
#include <cstdint>

#include "surflux/core/vec.h"

namespace surflux {

// Values at the corners of polygons, `width` each: polygon i has the corners [offsets[i], offsets[i + 1]), which stand
// at vertices[indices[k]].
struct PolygonValues {
    const Vec3* vertices;
    const std::int64_t *offsets, *indices;
    const double* values;
    std::size_t width;

    // Those at `count` points in the plane of a polygon, linear over a triangle of the fan around its first corner: the
    // one in which the first point is, or nearest to it. 0 of a polygon without area.
    void at(std::size_t polygon, const Vec3* points, std::size_t count, double* out) const;
};

}  // namespace surflux
