#pragma once

#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// Second-order surface model around a surfel, in the frame of its disk and in units of its radius: over (x, y) the
// normal's tangential part is t = g + K (x, y), K symmetric (the shape operator), and the height follows from it as on
// a sphere, where the chord between two points is normal to the sum of their normals. So spheres and planes are exact,
// and any smooth surface is to second order.
struct SurfaceModel {
    double kxx = 0.0, kxy = 0.0, kyy = 0.0;  // K
    double gx = 0.0, gy = 0.0;               // g: how far the surface's normal differs from the surfel's own
    double z0 = 0.0;                         // height over the surfel itself

    double height(double x, double y) const;
    // dA / (dx dy) = 1 / n_z
    double stretch(double x, double y) const;
};

// No normal of the model is turned by more than 60 degrees: n_z^2 >= 1/4.
constexpr double steepest_normal = 0.75;

struct OrientedPoint {
    Vec3 position, normal;
    double weight;
};

// The model that the points, normals and (0, 0, 0) with normal (0, 0, 1) agree on best, by weighted least squares on
// slopes: three equations a point, two for its normal and one for its chord. What noise they have it averages.
SurfaceModel fit_surface(const std::vector<OrientedPoint>& points);

}  // namespace surflux
