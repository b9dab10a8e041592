#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

struct SurfacePoint {
    Vec3 position;
    std::uint32_t triangle;
};

// `count` points on the triangles, uniform over their area; one in each of `count` slices of equal area.
std::vector<SurfacePoint> sample_triangles(const std::vector<std::array<Vec3, 3>>& triangles, std::size_t count,
                                           std::uint64_t seed);

}  // namespace surflux
