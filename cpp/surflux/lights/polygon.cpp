#include "surflux/lights/polygon.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/clip_polygon.h"
#include "surflux/core/sampling.h"

namespace surflux {

double element_to_polygon(const Vec3& point, const Vec3& normal, const Vec3* corners, std::size_t count) {
    // Clip at the horizon. A convex polygon gains one corner; one that lies in the horizon up to rounding may cross it
    // at every edge.
    Vec3 from_here[max_polygon_corners], v[2 * max_polygon_corners];
    for (std::size_t k = 0; k < count; ++k) from_here[k] = corners[k] - point;
    std::size_t n = 0;
    clip_polygon(from_here, count, -normal, 0.0, [&](const Vec3& p) { v[n++] = p; }, [](const Vec3&) {});
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
