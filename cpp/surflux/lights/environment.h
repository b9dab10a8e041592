#pragma once

#include <vector>

#include "surflux/core/sampling.h"
#include "surflux/scene/lights.h"

namespace surflux {

// Radiance of an Environment by direction, and directions drawn in proportion to it.
// Pixel (row, col) of a lat-long image looks along theta = pi (row + .5) / h from `up`, phi = 2 pi (col + .5) / w:
// (sin theta cos phi, sin theta sin phi, cos theta) in the frame that the shortest rotation of +z onto `up` makes,
// turned about `up` by the azimuth.
class EnvironmentMap {
public:
    explicit EnvironmentMap(const Environment& environment);

    bool is_constant() const { return environment_.pixels.empty(); }
    // The image's own axes: u towards its first column, n towards row 0.
    Frame frame() const { return {axis_x_, axis_y_, environment_.up}; }
    Rgb radiance(const Vec3& direction) const;
    // A direction with density (per steradian) in proportion to the luminance, of its size where
    // radiance is below 0; for images only.
    Vec3 sample(double s, double t) const;
    double density(const Vec3& direction) const;

private:
    Vec3 to_world(const Vec3& local) const;
    Vec3 to_local(const Vec3& world) const;
    std::size_t pixel_of(const Vec3& local) const;

    const Environment& environment_;
    Vec3 axis_x_, axis_y_;
    std::vector<double> row_up_to_;    // distribution of rows
    std::vector<double> pixel_up_to_;  // within each row
};

}  // namespace surflux
