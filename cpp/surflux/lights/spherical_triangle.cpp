#include "surflux/lights/spherical_triangle.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/sampling.h"

namespace surflux {

namespace {

double angle(const Vec3& a, const Vec3& b) { return std::atan2(length(cross(a, b)), dot(a, b)); }

// The part of a that is at right angles to unit b, as a unit vector.
Vec3 across(const Vec3& a, const Vec3& b) {
    const Vec3 d = a - dot(a, b) * b;
    const double size = length(d);
    return size > 0.0 ? d / size : d;
}

}  // namespace

Vec3 square_to_spherical_triangle(const Vec3& a, const Vec3& b, const Vec3& c, double s, double t) {
    const Vec3 ab = cross(a, b), bc = cross(b, c), ca = cross(c, a);
    const double alpha = angle(ab, -ca), beta = angle(bc, -ab), gamma = angle(ca, -bc);
    // The triangle a, b, c' with c' between a and c has the share s of the area.
    const double angles = pi + s * (alpha + beta + gamma - pi);
    const double sin_alpha = std::sin(alpha), cos_alpha = std::cos(alpha);
    const double sin_phi = std::sin(angles) * cos_alpha - std::cos(angles) * sin_alpha;
    const double cos_phi = std::cos(angles) * cos_alpha + std::sin(angles) * sin_alpha;
    const double k1 = cos_phi + cos_alpha, k2 = sin_phi - sin_alpha * dot(a, b);
    const double below = (k2 * sin_phi + k1 * cos_phi) * sin_alpha;
    const double cos_b =
        below != 0.0 ? std::clamp((k2 + (k2 * cos_phi - k1 * sin_phi) * cos_alpha) / below, -1.0, 1.0) : 1.0;
    const Vec3 moved = cos_b * a + std::sqrt(std::max(0.0, 1.0 - cos_b * cos_b)) * across(c, a);
    const double cosine = 1.0 - t * (1.0 - dot(moved, b));
    return cosine * b + std::sqrt(std::max(0.0, 1.0 - cosine * cosine)) * across(moved, b);
}

}  // namespace surflux
