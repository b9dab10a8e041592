#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "surflux/core/vec.h"
#include "surflux/scene/surfels.h"

namespace surflux {

constexpr std::size_t max_polygon_corners = 8;

// Form factor from a differential element at `point` with unit `normal` to a convex polygon, as far as the polygon lies
// above the element's horizon; whichever way the polygon faces. Lambert's formula:
// 1 / (2 pi) sum_k angle(v_k, v_k+1) n . unit(v_k x v_k+1). In [0, 1].
double element_to_polygon(const Vec3& point, const Vec3& normal, const Vec3* corners, std::size_t count);

// A height over a plane that is none: by rounding of the coordinates of two places, and of a normal over what is so
// long. A lamp that lies in a wall lights none of it; were it a digit before that, half of its power would go there.
inline double no_height(const Vec3& a, const Vec3& b, double length) {
    const auto largest = [](const Vec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); };
    return 1e-12 * std::max(largest(a), largest(b)) + 1e-6 * length;
}

// Solid angle of a triangle (Van Oosterom and Strackee 1983).
double solid_angle(const Vec3& eye, const Triangle& t);

}  // namespace surflux
