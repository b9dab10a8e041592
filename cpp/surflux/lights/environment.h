#pragma once

#include <vector>

#include "surflux/core/sampling.h"
#include "surflux/scene/lights.h"

namespace surflux {

// Radiance of an Environment by direction, and directions drawn in proportion to it.
// Pixel (row, col) of a lat-long image looks along theta = pi (row + .5) / h from `up` and, clockwise seen from its
// tip, as cameras see a panorama from left to right, along the angle 2 pi (col + .5) / w from the left border of column
// 0. For up = +z that border looks along -x, the middle of the image along +x, as in Blender; the shortest rotation of
// +z onto `up` turns them (for +y: as in three.js), and then a turn about `up` by the azimuth.
class EnvironmentMap {
public:
    explicit EnvironmentMap(const Environment& environment);

    bool is_constant() const { return environment_.pixels.empty(); }
    // The image's own axes: u towards the left border of column 0, v towards that of column w / 4, n towards row 0.
    // They are left-handed, so that angles from u to v grow with columns.
    Frame image_frame() const { return {axis_u_, axis_v_, environment_.up}; }
    // The right-handed axes of the scene, as `up` and azimuth turn them: u towards the middle of the image.
    Frame frame() const { return {-axis_u_, axis_v_, environment_.up}; }
    Rgb radiance(const Vec3& direction) const;
    // A direction with density (per steradian) in proportion to the luminance, of its size where
    // radiance is below 0; for images only.
    Vec3 sample(double s, double t) const;
    double density(const Vec3& direction) const;

private:
    // Of the image's own axes.
    Vec3 to_world(const Vec3& local) const;
    Vec3 to_local(const Vec3& world) const;
    std::size_t pixel_of(const Vec3& local) const;

    const Environment& environment_;
    Vec3 axis_u_, axis_v_;             // of image_frame
    std::vector<double> row_up_to_;    // distribution of rows
    std::vector<double> pixel_up_to_;  // within each row
};

}  // namespace surflux
