#pragma once

#include <cstddef>
#include <variant>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

struct PointLight {
    Vec3 position;
    Rgb intensity;  // W/sr
};

struct SpotLight {
    Vec3 position;
    Vec3 direction;         // unit, from the light into the scene
    Rgb intensity;          // W/sr on the axis
    double cone = 45.0;     // full angle in degrees where the light ends
    double penumbra = 5.0;  // full angle in degrees over which it fades: smoothstep in angle
};

// A point whose intensity goes by direction, as photometry has it on half-planes about an axis (CIE 121: C and gamma).
struct PhotometricLight {
    Vec3 position;
    Vec3 direction;   // unit, of gamma = 0
    Vec3 zero_plane;  // unit, perpendicular to it: half-plane C = 0; C = 90 is towards zero_plane x direction
    Rgb intensity;    // W/sr where the table has 1
    std::vector<double> planes;  // C in degrees, ascending from 0 to 360
    std::vector<double> angles;  // gamma in degrees, ascending; below the first and above the last there is no light
    std::vector<double> table;   // planes x angles, at least 0; linear in both angles between
};

// A rectangle that emits along edge_u x edge_v; it does not occlude and does not reflect.
struct AreaLight {
    Vec3 corner, edge_u, edge_v;
    Rgb exitance;  // W/m2
};

struct DirectionalLight {
    Vec3 direction;  // unit, of travel
    Rgb irradiance;  // on a plane that faces it
};

// Radiance from the full sphere: constant where `pixels` is empty, else a lat-long image, row 0 towards `up`, columns
// clockwise seen from its tip (lights/environment.h).
struct Environment {
    Rgb radiance;
    std::size_t width = 0, height = 0;
    std::vector<Rgb> pixels;  // row-major, height x width
    Vec3 up{0, 0, 1};         // unit
    double azimuth = 0.0;     // degrees by which the image is turned about `up`, counter-clockwise seen from its tip
};

using Light = std::variant<PointLight, SpotLight, PhotometricLight, AreaLight, DirectionalLight, Environment>;

}  // namespace surflux
