#include "surflux/render/seen_lamps.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double in_front = 0.99999;  // a lamp in the plane of a ceiling is seen

struct Rectangle {
    Vec3 corner, u, v, normal;
    double squared;

    explicit Rectangle(const AreaLight& light)
        : corner(light.corner),
          u(light.edge_u),
          v(light.edge_v),
          normal(cross(u, v)),
          squared(length_squared(normal)) {}

    // The depth at which a ray, of length 1 along the view axis, meets its front, or 0.
    double depth_along(const Vec3& origin, const Vec3& direction) const {
        const double along = dot(normal, direction);
        if (!(along < 0.0)) return 0.0;
        const double depth = dot(normal, corner - origin) / along;
        if (!(depth > 0.0)) return 0.0;
        const Vec3 at = origin + depth * direction - corner;
        const double s = dot(cross(at, v), normal) / squared, t = dot(cross(u, at), normal) / squared;
        return s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0 ? depth : 0.0;
    }
};

struct Rows {
    std::size_t top, bottom;
};

// In which it may be seen: all where it reaches the plane of the eye.
Rows rows_of(const Rectangle& r, const PixelRays& rays) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Vec3& p : {r.corner, r.corner + r.u, r.corner + r.v, r.corner + r.u + r.v}) {
        const Vec3 at = rays.frame.to_camera(p);
        if (!(at.z > 0.0)) return {0, rays.height};
        const double row = at.y / rays.size_at(at.z) + 0.5 * static_cast<double>(rays.height);
        low = std::min(low, row), high = std::max(high, row);
    }
    const auto clamped = [&](double row) {
        return static_cast<std::size_t>(std::clamp(row, 0.0, static_cast<double>(rays.height)));
    };
    return {clamped(std::floor(low) - 1.0), clamped(std::ceil(high) + 1.0)};
}

}  // namespace

void find_lamps(const std::vector<Light>& lights, const PixelPlaces& places, SeenLamps& out) {
    const PixelRays& rays = places.rays;
    out.lamp.clear();
    for (std::size_t k = 0; k < lights.size(); ++k) {
        const auto* light = std::get_if<AreaLight>(&lights[k]);
        if (!light) continue;
        const Rectangle rectangle(*light);
        const Rows rows = rows_of(rectangle, rays);
        if (rows.top >= rows.bottom) continue;
        if (out.lamp.empty()) {
            out.lamp.assign(places.size(), SeenLamps::none);
            out.depth = places.depth;
        }
        parallel_for(rows.bottom - rows.top, 4, [&](std::size_t row) {
            const std::size_t line = rows.top + row;
            for (std::size_t column = 0; column < rays.width; ++column) {
                const auto x = static_cast<double>(column), y = static_cast<double>(line);
                const double depth = rectangle.depth_along(rays.origin(x, y), rays.direction(x, y));
                const std::size_t p = line * rays.width + column;
                if (!(depth > 0.0) || in_front * depth >= static_cast<double>(out.depth[p])) continue;
                out.depth[p] = static_cast<float>(depth);
                out.lamp[p] = static_cast<std::int32_t>(k);
            }
        });
    }
}

}  // namespace surflux
