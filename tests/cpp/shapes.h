#pragma once

// Scenes that several tests build.

#include <cmath>
#include <vector>

#include "surflux/area/effective_area.h"
#include "surflux/core/sampling.h"
#include "surflux/neighbors/radii.h"
#include "surflux/scene/scene.h"

namespace surflux::shapes {

inline void finish(Surfels& s, double rho, double emission) {
    s.reflectance = Colors(s.size(), {rho, rho, rho});
    s.emission = Colors(s.size(), {emission, emission, emission});
}

// m x n parallelogram patches, facing along u x v.
inline void add_rectangle(Surfels& s, const Vec3& corner, const Vec3& u, const Vec3& v, int m, int n) {
    for (int a = 0; a < m; ++a)
        for (int b = 0; b < n; ++b) {
            const Vec3 du = u / m, dv = v / n, o = corner + a * du + b * dv;
            const auto index = static_cast<std::uint32_t>(s.size());
            s.positions.push_back(o + 0.5 * du + 0.5 * dv);
            s.normals.push_back(normalized(cross(u, v)));
            s.radii.push_back(0.5 * std::max(length(du + dv), length(du - dv)));
            s.areas.push_back(length(cross(du, dv)));
            s.triangles.push_back({o, o + du, o + du + dv, index});
            s.triangles.push_back({o, o + du + dv, o + dv, index});
        }
}

// The unit cube seen from inside; face k has its surfels at [k n^2, (k + 1) n^2). Faces 0 and 1 are opposite.
inline Surfels cube_inside(int n, double rho, double emission) {
    Surfels s;
    const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, o;
    add_rectangle(s, o, x, y, n, n);
    add_rectangle(s, z, y, x, n, n);
    add_rectangle(s, o, y, z, n, n);
    add_rectangle(s, x, z, y, n, n);
    add_rectangle(s, o, z, x, n, n);
    add_rectangle(s, y, x, z, n, n);
    finish(s, rho, emission);
    return s;
}

// n surfels on a Fibonacci sphere, facing out (sign 1) or in (sign -1), with the paper's areas.
inline Surfels sphere(std::size_t n, double radius, double sign, double rho, double emission, const Vec3& center = {}) {
    Surfels s;
    for (std::size_t i = 0; i < n; ++i) {
        const double z = 1.0 - 2.0 * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
        const double phi = pi * (1.0 + std::sqrt(5.0)) * static_cast<double>(i), r = std::sqrt(1.0 - z * z);
        const Vec3 n_out{r * std::cos(phi), r * std::sin(phi), z};
        s.positions.push_back(center + radius * n_out);
        s.normals.push_back(sign * n_out);
    }
    finish(s, rho, emission);
    s.radii = estimate_radii(s.positions);
    s.areas = effective_areas(s, {});
    return s;
}

inline Surfels disk(const Vec3& center, const Vec3& normal, double radius) {
    Surfels s;
    s.positions = {center};
    s.normals = {normal};
    s.radii = {radius};
    s.areas = {pi * radius * radius};
    finish(s, 0.5, 0.0);
    return s;
}

inline Scene scene_of(const std::vector<Surfels>& objects, std::vector<Light> lights = {}) {
    Scene scene;
    for (const Surfels& s : objects) append(scene, s);
    scene.lights = std::move(lights);
    return scene;
}

// A unit sphere seen from inside, of reflectance .5.
inline Scene sphere_inside(std::size_t points) {
    Scene scene;
    append(scene, sphere(points, 1.0, -1.0, 0.5, 0.0));
    return scene;
}

}  // namespace surflux::shapes
