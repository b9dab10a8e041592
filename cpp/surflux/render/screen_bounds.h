#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "surflux/core/vec.h"

namespace surflux {

// Whole pixels, the last ones not counted in.
struct PixelBox {
    int left = 0, top = 0, right = 0, bottom = 0;
    bool empty() const { return left >= right || top >= bottom; }
};

// An ellipsoid by its half axes, which stand at right angles to each other, in the camera's frame.
struct Ellipsoid {
    Vec3 center;
    std::array<Vec3, 3> axes;
};

// Slopes (x / z, or y / z) under which it is seen from the eye: exact, for the planes through the eye that touch it.
// All of them where it reaches the plane of the eye.
inline std::array<double, 2> seen_slopes(const Ellipsoid& e, int axis) {
    constexpr double all = 1e30;
    double xx = 0.0, xz = 0.0, zz = 0.0;  // x - a z = 0 touches where (c_x - a c_z)^2 is the square of its reach
    for (const Vec3& half : e.axes) {
        xx += half[axis] * half[axis];
        xz += half[axis] * half.z;
        zz += half.z * half.z;
    }
    const double c = e.center[axis], z = e.center.z;
    if (!(z > 0.0) || z * z <= zz * (1.0 + 1e-9)) return {-all, all};
    const double a = z * z - zz, b = c * z - xz;
    // b^2 - a (c^2 - xx), in a form that does not cancel.
    const double root = std::sqrt(std::max(0.0, z * z * xx - 2.0 * c * z * xz + c * c * zz - (xx * zz - xz * xz)));
    return {(b - root) / a, (b + root) / a};
}

// Is it beyond one of the planes that bound the view? What is beside the eye has no slopes, and mostly is.
inline bool out_of_view(const Ellipsoid& e, double tan_x, double tan_y) {
    for (const Vec3& outwards : {Vec3{1, 0, -tan_x}, Vec3{-1, 0, -tan_x}, Vec3{0, 1, -tan_y}, Vec3{0, -1, -tan_y}}) {
        double squared = 0.0;
        for (const Vec3& half : e.axes) squared += dot(outwards, half) * dot(outwards, half);
        const double beyond = dot(outwards, e.center);
        if (beyond > 0.0 && beyond * beyond > squared) return true;
    }
    return false;
}

// Where it ends along an axis of the picture, under parallel rays.
inline std::array<double, 2> seen_places(const Ellipsoid& e, int axis) {
    double squared = 0.0;
    for (const Vec3& half : e.axes) squared += half[axis] * half[axis];
    return {e.center[axis] - std::sqrt(squared), e.center[axis] + std::sqrt(squared)};
}

// The pixels of a picture of width x height whose centres may see it. tan_x and tan_y: of half the field of view, or
// half of what parallel rays show.
inline PixelBox seen_pixels(const Ellipsoid& e, double tan_x, double tan_y, int width, int height,
                            bool parallel = false) {
    if (!parallel && out_of_view(e, tan_x, tan_y)) return {};
    const auto first = [](double slope, double tangent, int count) {
        const double at = 0.5 * count * (slope / tangent + 1.0);
        return static_cast<int>(std::ceil(std::clamp(at - 0.501, -1.0, count + 1.0)));
    };
    const auto end = [](double slope, double tangent, int count) {
        const double at = 0.5 * count * (slope / tangent + 1.0);
        return static_cast<int>(std::floor(std::clamp(at - 0.499, -2.0, count + 1.0))) + 1;
    };
    const auto [x_low, x_high] = parallel ? seen_places(e, 0) : seen_slopes(e, 0);
    const auto [y_low, y_high] = parallel ? seen_places(e, 1) : seen_slopes(e, 1);
    return {std::max(0, first(x_low, tan_x, width)), std::max(0, first(y_low, tan_y, height)),
            std::min(width, end(x_high, tan_x, width)), std::min(height, end(y_high, tan_y, height))};
}

}  // namespace surflux
