#include "surflux/trace/joined_patches.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "surflux/core/disjoint_sets.h"
#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double tolerance = 0.01;  // of the shorter edge: so much edges may lie beside each other
constexpr double flat = 0.99;       // cosine of normals that go straight on

// Do two edges lie on each other in part, and not only end to end?
bool overlap(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const Vec3 edge = b - a;
    const double length_of_it = length(edge), near = tolerance * std::min(length_of_it, length(d - c));
    if (!(near > 0.0)) return false;
    const Vec3 along = edge / length_of_it;
    const double at_c = dot(c - a, along), at_d = dot(d - a, along);
    if (length(c - a - at_c * along) > near || length(d - a - at_d * along) > near) return false;
    return std::min(std::max(at_c, at_d), length_of_it) - std::max(std::min(at_c, at_d), 0.0) > near;
}

using Corners = std::array<Vec3, 4>;  // the first one twice

Corners corners_of(const Triangle& t) { return {t.a, t.b, t.c, t.a}; }

bool has_edge(const Triangle& t, const Vec3& a, const Vec3& b) {
    const Corners q = corners_of(t);
    return overlap(a, b, q[0], q[1]) || overlap(a, b, q[1], q[2]) || overlap(a, b, q[2], q[3]);
}

}  // namespace

std::vector<std::uint32_t> joined_patches(const Surfels& s, const NeighborGraph& near) {
    const std::vector<std::uint32_t> begin = triangle_ranges(s);
    const auto has_edge_at = [&](std::size_t j, const Vec3& a, const Vec3& b) {
        return std::any_of(s.triangles.begin() + begin[j], s.triangles.begin() + begin[j + 1],
                           [&](const Triangle& t) { return has_edge(t, a, b); });
    };
    // Where a patch goes straight on beyond its edge, what else begins there, as the box that stands on a floor that is
    // cut along it, is another piece.
    const auto goes_on_without = [&](std::size_t i, std::size_t j, const Vec3& a, const Vec3& b) {
        if (dot(s.normals[i], s.normals[j]) > flat) return false;
        const auto goes_on = [&](std::uint32_t k) {
            return k != i && k != j && dot(s.normals[i], s.normals[k]) > flat && has_edge_at(k, a, b);
        };
        return std::any_of(near[i].begin(), near[i].end(), goes_on) ||
               std::any_of(near[j].begin(), near[j].end(), goes_on);
    };
    // Two that touch face to face, on one side of the edge, as a box and the floor beneath it.
    const auto lies_on = [&](std::size_t i, const Triangle& of_i, std::size_t j, const Vec3& a, const Vec3& b) {
        if (dot(s.normals[i], s.normals[j]) > -flat) return false;
        const Vec3 aside = cross(s.normals[i], b - a);
        const bool side = dot(aside, of_i.a + of_i.b + of_i.c - 3.0 * a) > 0.0;
        for (std::uint32_t l = begin[j]; l < begin[j + 1]; ++l) {
            const Triangle& t = s.triangles[l];
            if (has_edge(t, a, b) && (dot(aside, t.a + t.b + t.c - 3.0 * a) > 0.0) == side) return true;
        }
        return false;
    };
    const auto joined = [&](std::size_t i, std::size_t j) {
        for (std::uint32_t k = begin[i]; k < begin[i + 1]; ++k) {
            const Triangle& t = s.triangles[k];
            const Corners p = corners_of(t);
            for (std::size_t e = 0; e < 3; ++e)
                if (has_edge_at(j, p[e], p[e + 1]) && !lies_on(i, t, j, p[e], p[e + 1]) &&
                    !goes_on_without(i, j, p[e], p[e + 1]) && !goes_on_without(j, i, p[e], p[e + 1]))
                    return true;
        }
        return false;
    };
    std::vector<std::vector<std::uint32_t>> found(s.size());
    parallel_for(s.size(), 256, [&](std::size_t i) {
        for (const std::uint32_t j : near[i])
            if (joined(i, j)) found[i].push_back(j);
    });
    DisjointSets pieces(s.size());
    for (std::uint32_t i = 0; i < s.size(); ++i)
        for (const std::uint32_t j : found[i]) pieces.join(i, j);
    return pieces.numbered(s.size());
}

}  // namespace surflux
