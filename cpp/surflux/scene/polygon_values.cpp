#include "surflux/scene/polygon_values.h"

#include <algorithm>
#include <limits>

namespace surflux {

namespace {

// Weights of the second and the third corner of a triangle at points in its plane.
struct CornerWeights {
    CornerWeights(const Vec3& a, const Vec3& b, const Vec3& c)
        : corner(a), side(b - a), other(c - a), normal(cross(side, other)), squared(dot(normal, normal)) {}

    double second(const Vec3& point) const { return dot(cross(point - corner, other), normal) / squared; }
    double third(const Vec3& point) const { return dot(cross(side, point - corner), normal) / squared; }

    Vec3 corner, side, other, normal;
    double squared;
};

}  // namespace

void PolygonValues::at(std::size_t polygon, const Vec3* points, std::size_t count, double* out) const {
    const std::int64_t first = offsets[polygon], end = offsets[polygon + 1];
    const auto corner = [&](std::int64_t k) { return vertices[indices[k]]; };
    std::int64_t nearest = -1;
    double inside = -std::numeric_limits<double>::infinity();
    for (std::int64_t k = first + 1; k + 1 < end; ++k) {
        const CornerWeights weights(corner(first), corner(k), corner(k + 1));
        const double s = weights.second(points[0]), t = weights.third(points[0]);
        const double depth = std::min({s, t, 1.0 - s - t});
        if (weights.squared > 0.0 && depth > inside) inside = depth, nearest = k;
    }
    std::fill_n(out, count * width, 0.0);
    if (nearest < 0) return;
    const CornerWeights weights(corner(first), corner(nearest), corner(nearest + 1));
    const double *a = values + first * static_cast<std::int64_t>(width),
                 *b = values + nearest * static_cast<std::int64_t>(width), *c = b + width;
    for (std::size_t p = 0; p < count; ++p) {
        const double s = weights.second(points[p]), t = weights.third(points[p]);
        for (std::size_t i = 0; i < width; ++i) out[p * width + i] = (1.0 - s - t) * a[i] + s * b[i] + t * c[i];
    }
}

}  // namespace surflux
