#pragma once

#include <cmath>
#include <cstddef>

#include "surflux/core/vec.h"

namespace surflux {

// Parts a convex polygon by a plane: hands the corners with dot(normal, p) <= limit to `inside`, those beyond to
// `outside`, and where edges cross the plane to both, each in order (Sutherland and Hodgman 1974). Corners no farther
// than `snap` from the plane are on it.
template <class Inside, class Outside>
void clip_polygon(const Vec3* corners, std::size_t count, const Vec3& normal, double limit, const Inside& inside,
                  const Outside& outside, double snap = 0.0) {
    const auto height = [&](const Vec3& p) {
        const double at = dot(normal, p) - limit;
        return std::abs(at) <= snap ? 0.0 : at;
    };
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3 &a = corners[k], &b = corners[(k + 1) % count];
        const double at_a = height(a), at_b = height(b);
        if (at_a <= 0.0) inside(a);
        if (at_a >= 0.0) outside(a);
        if ((at_a < 0.0 && at_b > 0.0) || (at_a > 0.0 && at_b < 0.0)) {
            const Vec3 between = a + at_a / (at_a - at_b) * (b - a);
            inside(between);
            outside(between);
        }
    }
}

}  // namespace surflux
