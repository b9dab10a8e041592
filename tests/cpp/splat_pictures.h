#pragma once

// What tests of splatted pictures are made of.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/sampling.h"
#include "surflux/render/splat.h"

namespace surflux {

inline void add_disk(Surfels& s, const Vec3& position, const Vec3& normal, double radius) {
    s.positions.push_back(position);
    s.normals.push_back(normal);
    s.radii.push_back(radius);
    s.reflectance.push_back({});
    s.emission.push_back({});
}

// A square of cells x cells patches of two triangles each.
inline void add_square(Surfels& s, const Vec3& corner, const Vec3& u, const Vec3& v, int cells) {
    const Vec3 du = u / cells, dv = v / cells;
    for (int i = 0; i < cells; ++i) {
        for (int j = 0; j < cells; ++j) {
            const Vec3 a = corner + i * du + j * dv;
            add_disk(s, a + 0.5 * (du + dv), normalized(cross(u, v)), 0.5 * length(du + dv));
            const auto surfel = static_cast<std::uint32_t>(s.size() - 1);
            s.triangles.push_back({a, a + du, a + du + dv, surfel});
            s.triangles.push_back({a, a + du + dv, a + dv, surfel});
        }
    }
}

// The cube [-1, 1]^3, faces in the order +x -x +y -y +z -z, cells x cells patches each.
inline Surfels cube(int cells) {
    Surfels s;
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {1.0, -1.0}) {
            Vec3 corner{-1, -1, -1}, u, v;
            corner[axis] = side;
            u[(axis + 1) % 3] = 2.0;
            v[(axis + 2) % 3] = 2.0;
            if (side > 0.0)
                add_square(s, corner, u, v, cells);
            else
                add_square(s, corner, v, u, cells);
        }
    }
    return s;
}

inline Surfels sphere(std::size_t n, const Vec3& center, double radius) {
    Surfels s;
    for (std::size_t i = 0; i < n; ++i) {  // Fibonacci; disks that reach 1.3 times the spacing
        const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(n);
        const double phi = static_cast<double>(i) * pi * (3.0 - std::sqrt(5.0)), r = std::sqrt(1.0 - z * z);
        const Vec3 normal{r * std::cos(phi), r * std::sin(phi), z};
        add_disk(s, center + radius * normal, normal, 1.3 * radius * std::sqrt(4.0 * pi / static_cast<double>(n)));
    }
    return s;
}

inline const Camera front{{0, -4, 0}, {0, 0, 0}, {0, 0, 1}, 60.0};

inline std::vector<Rgb> constant(const Surfels& s, const Rgb& color) { return std::vector<Rgb>(s.size(), color); }

// One layer, for all that needs no more.
struct Picture : SplatImage {
    std::vector<float> radiance;
};

inline Picture picture(const Surfels& surfels, const std::vector<Rgb>& radiance,
                       const std::vector<VisibleEmitter>& lamps, const Camera& camera, std::size_t width,
                       std::size_t height, gl::Api api, const SplatOptions& options = {}) {
    Picture out{splat_image(surfels, {{radiance}}, lamps, camera, width, height, options, {}, api), {}};
    out.radiance = out.layers[0];
    return out;
}

inline Rgb pixel(const Picture& image, std::size_t x, std::size_t y) {
    const float* p = &image.radiance[3 * (y * image.width + x)];
    return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

}  // namespace surflux
