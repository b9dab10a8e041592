#include "surflux/lights/polygon.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/clip_polygon.h"
#include "surflux/core/sampling.h"

namespace surflux {

namespace {

// Over its distance, how wide a polygon is below which its factor is the difference of nearly equal numbers: that of
// its edges is off by 2^-53 over the square of this, the quadrature by its fourth power.
constexpr double narrow = 1e-4;

// The factor of a narrow polygon: each triangle of a fan by the middles of its edges.
double element_to_narrow_polygon(const Vec3& normal, const Vec3* v, std::size_t n) {
    double sum = 0.0;
    for (std::size_t k = 1; k + 1 < n; ++k) {
        const Vec3 across = 0.5 * cross(v[k] - v[0], v[k + 1] - v[0]);
        for (const Vec3& at : {0.5 * (v[0] + v[k]), 0.5 * (v[k] + v[k + 1]), 0.5 * (v[k + 1] + v[0])}) {
            const double squared = length_squared(at);
            sum += dot(at, normal) * dot(at, across) / (squared * squared);
        }
    }
    return std::min(1.0, std::abs(sum) / (3.0 * pi));
}

}  // namespace

double element_to_polygon(const Vec3& point, const Vec3& normal, const Vec3* corners, std::size_t count) {
    // Clip at the horizon. A convex polygon gains one corner; one that lies in the horizon up to rounding may cross it
    // at every edge.
    Vec3 from_here[max_polygon_corners], v[2 * max_polygon_corners];
    for (std::size_t k = 0; k < count; ++k) from_here[k] = corners[k] - point;
    std::size_t n = 0;
    clip_polygon(from_here, count, -normal, 0.0, [&](const Vec3& p) { v[n++] = p; }, [](const Vec3&) {});
    if (n < 3) return 0.0;
    double width = 0.0;
    for (std::size_t k = 1; k < n; ++k) width = std::max(width, length_squared(v[k] - v[0]));
    if (width < narrow * narrow * length_squared(v[0])) return element_to_narrow_polygon(normal, v, n);
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

// Van Oosterom and Strackee (1983). Of a far triangle the product of its corners is the difference of nearly equal
// numbers; that with its edges is the same, and is none.
double solid_angle(const Vec3& eye, const Triangle& t) {
    const Vec3 a = t.a - eye, b = t.b - eye, c = t.c - eye;
    const double la = length(a), lb = length(b), lc = length(c);
    return 2.0 * std::abs(std::atan2(dot(a, cross(t.b - t.a, t.c - t.a)),
                                     la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb));
}

}  // namespace surflux
