#pragma once

#include <algorithm>
#include <cmath>

namespace surflux {

// An ellipse in a plane: the direction of its long half axis, and the squares of both.
struct Ellipse {
    double x, y;
    double along, across;
};

// Of a symmetric matrix, such as of squares of half axes that are turned, or of a sum of such.
inline Ellipse ellipse_of(double xx, double xy, double yy) {
    const double middle = 0.5 * (xx + yy), half = 0.5 * (xx - yy), off = std::hypot(half, xy);
    const double angle = off > 0.0 ? 0.5 * std::atan2(xy, half) : 0.0;
    return {std::cos(angle), std::sin(angle), middle + off, std::max(0.0, middle - off)};
}

}  // namespace surflux
