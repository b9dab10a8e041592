#pragma once

#include <cmath>

namespace surflux {

// Of a symmetric matrix in a plane, such as one of curvatures, or of squares of an ellipse's half axes: the direction
// of the first of its eigenvectors, which stand at right angles to each other, and both eigenvalues, the largest first.
struct PrincipalAxes {
    double x, y;
    double along, across;
};

inline PrincipalAxes principal_axes(double xx, double xy, double yy) {
    const double middle = 0.5 * (xx + yy), half = 0.5 * (xx - yy), off = std::hypot(half, xy);
    const double angle = 0.5 * std::atan2(xy, half);
    return {std::cos(angle), std::sin(angle), middle + off, middle - off};
}

}  // namespace surflux
