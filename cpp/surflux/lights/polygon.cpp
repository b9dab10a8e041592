#include "surflux/lights/polygon.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/sampling.h"

namespace surflux {

double element_to_polygon(const Vec3& point, const Vec3& normal, const Vec3* corners, std::size_t count) {
    // Clip at the horizon (Sutherland and Hodgman). A convex polygon gains one corner; one that lies in the horizon up
    // to rounding may cross it at every edge.
    Vec3 v[2 * max_polygon_corners];
    std::size_t n = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3 a = corners[k] - point, b = corners[(k + 1) % count] - point;
        const double height_a = dot(a, normal), height_b = dot(b, normal);
        if (height_a >= 0.0) v[n++] = a;
        if ((height_a > 0.0 && height_b < 0.0) || (height_a < 0.0 && height_b > 0.0))
            v[n++] = a + (height_a / (height_a - height_b)) * (b - a);
    }
    if (n < 3) return 0.0;
    double sum = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
        const Vec3 &a = v[k], &b = v[(k + 1) % n];
        const Vec3 axis = cross(a, b);
        const double sine = length(axis);
        // Both on a line with the point: the edge is seen end on (0), or the point lies on it, where the factor of the
        // whole edge lies in the element's plane and adds nothing.
        if (sine > 0.0) sum += std::atan2(sine, dot(a, b)) / sine * dot(axis, normal);
    }
    return std::min(1.0, std::abs(sum) / (2.0 * pi));
}

double solid_angle(const Vec3& eye, const Triangle& t) {
    const Vec3 a = t.a - eye, b = t.b - eye, c = t.c - eye;
    const double la = length(a), lb = length(b), lc = length(c);
    return 2.0 *
           std::abs(std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb));
}

}  // namespace surflux
