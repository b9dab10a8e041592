#include "surflux/render/joined_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double touching = 0.05;  // of a patch's reach: as far cracks between patches are closed
constexpr int most = 64;           // neighbours that are asked: around the apex of a fan are thousands
constexpr double blending = 0.5;   // cosine of normals from which on surfaces blend (kernel_fragment)

double squared_distance_to_edge(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 edge = b - a;
    const double squared = length_squared(edge);
    const double at = squared > 0.0 ? std::clamp(dot(p - a, edge) / squared, 0.0, 1.0) : 0.0;
    return length_squared(p - a - at * edge);
}

// Is a corner of one on an edge of the other?
bool touch(const Triangle& one, const Triangle& other, double tolerance) {
    for (const Vec3* p : {&one.a, &one.b, &one.c})
        if (*p == other.a || *p == other.b || *p == other.c) return true;
    const auto on_edge = [&](const Vec3& p, const Triangle& t) {
        const double near = tolerance * tolerance;
        return squared_distance_to_edge(p, t.a, t.b) <= near || squared_distance_to_edge(p, t.b, t.c) <= near ||
               squared_distance_to_edge(p, t.c, t.a) <= near;
    };
    return on_edge(one.a, other) || on_edge(one.b, other) || on_edge(one.c, other) || on_edge(other.a, one) ||
           on_edge(other.b, one) || on_edge(other.c, one);
}

bool is_near(const Box& box, const Triangle& t, double tolerance) {
    for (int axis = 0; axis < 3; ++axis)
        if (std::min({t.a[axis], t.b[axis], t.c[axis]}) > box.high[axis] + tolerance ||
            std::max({t.a[axis], t.b[axis], t.c[axis]}) < box.low[axis] - tolerance)
            return false;
    return true;
}

}  // namespace

std::vector<float> joined_depths(const Surfels& s, const BoxTree& tree, const std::vector<Reach>& reach,
                                 const Progress& progress) {
    std::vector<float> out(s.size(), std::numeric_limits<float>::infinity());
    const std::vector<std::uint32_t> begin = triangle_ranges(s);
    const auto find = [&](std::size_t i) {
        const double tolerance = touching * std::min(reach[i].along, reach[i].across);
        double depth = 0.0;
        int left = most;
        for (std::uint32_t own = begin[i]; own < begin[i + 1]; ++own) {
            const Triangle& t = s.triangles[own];
            const auto meets = [&](const Box& box) { return left > 0 && is_near(box, t, tolerance); };
            tree.visit(meets, [&](std::uint32_t k) {
                const Triangle& other = s.triangles[k];
                if (other.surfel == i || dot(s.normals[i], s.normals[other.surfel]) < blending) return;
                if (left == 0 || !touch(t, other, tolerance)) return;
                --left;
                for (const Vec3* corner : {&other.a, &other.b, &other.c})
                    depth = std::max(depth, std::abs(dot(s.normals[i], *corner - s.positions[i])));
            });
        }
        if (begin[i] < begin[i + 1]) out[i] = static_cast<float>(depth);
    };
    parallel_for(s.size(), 1024, find, progress);
    return out;
}

}  // namespace surflux
