#pragma once

#include <algorithm>
#include <cmath>

#include "surflux/core/vec.h"

namespace surflux {

constexpr double pi = 3.14159265358979323846;

// Unit square -> unit disk, area preserving and continuous (Shirley and Chiu 1997).
inline void square_to_disk(double s, double t, double& x, double& y) {
    const double a = 2.0 * s - 1.0, b = 2.0 * t - 1.0;
    if (a == 0.0 && b == 0.0) return void(x = y = 0.0);
    double radius, angle;
    if (std::abs(a) > std::abs(b)) {
        radius = a;
        angle = (pi / 4.0) * (b / a);
    } else {
        radius = b;
        angle = pi / 2.0 - (pi / 4.0) * (a / b);
    }
    x = radius * std::cos(angle);
    y = radius * std::sin(angle);
}

// Unit square -> hemisphere around +z, density cos(theta)/pi (Malley).
inline Vec3 square_to_cosine_hemisphere(double s, double t) {
    Vec3 d;
    square_to_disk(s, t, d.x, d.y);
    d.z = std::sqrt(std::max(0.0, 1.0 - d.x * d.x - d.y * d.y));
    return d;
}

// Unit square -> barycentric weights of a uniformly distributed point of a triangle.
inline Vec3 square_to_triangle(double s, double t) {
    const double root = std::sqrt(s);
    return {1.0 - root, root * (1.0 - t), root * t};
}

}  // namespace surflux
