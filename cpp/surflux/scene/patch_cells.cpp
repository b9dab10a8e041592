#include "surflux/scene/patch_cells.h"

namespace surflux {

namespace {

// The part of a convex polygon on the near side of a plane (Sutherland and Hodgman 1974).
std::vector<Vec3> clipped(const std::vector<Vec3>& polygon, const Vec3& normal, const Vec3& on_plane) {
    std::vector<Vec3> out;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vec3 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
        const double at_a = dot(normal, a - on_plane), at_b = dot(normal, b - on_plane);
        if (at_a <= 0.0) out.push_back(a);
        if ((at_a < 0.0 && at_b > 0.0) || (at_a > 0.0 && at_b < 0.0)) out.push_back(a + at_a / (at_a - at_b) * (b - a));
    }
    return out;
}

}  // namespace

std::vector<std::vector<Triangle>> patch_cells(const Triangle* begin, const Triangle* end, const Vec3* points,
                                               std::size_t count) {
    std::vector<std::vector<Triangle>> out(count);
    for (const Triangle* t = begin; t != end; ++t)
        for (std::size_t k = 0; k < count; ++k) {
            std::vector<Vec3> part{t->a, t->b, t->c};
            for (std::size_t other = 0; other < count && part.size() >= 3; ++other)
                if (other != k) part = clipped(part, points[other] - points[k], 0.5 * (points[other] + points[k]));
            for (std::size_t c = 2; c < part.size(); ++c) {
                const Triangle piece{part[0], part[c - 1], part[c], t->surfel};
                if (area_of(piece) > 0.0) out[k].push_back(piece);
            }
        }
    return out;
}

}  // namespace surflux
