#include "surflux/trace/joined_patches.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "surflux/core/disjoint_sets.h"
#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double tolerance = 0.01;  // of the shorter edge: so much edges may lie beside each other

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

bool share_an_edge(const Triangle& one, const Triangle& other) {
    const std::array<Vec3, 4> p{one.a, one.b, one.c, one.a}, q{other.a, other.b, other.c, other.a};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            if (overlap(p[i], p[i + 1], q[k], q[k + 1])) return true;
    return false;
}

}  // namespace

std::vector<std::uint32_t> joined_patches(const Surfels& s, const NeighborGraph& near) {
    const std::vector<std::uint32_t> begin = triangle_ranges(s);
    const auto joined = [&](std::size_t i, std::size_t j) {
        for (std::uint32_t k = begin[i]; k < begin[i + 1]; ++k)
            for (std::uint32_t l = begin[j]; l < begin[j + 1]; ++l)
                if (share_an_edge(s.triangles[k], s.triangles[l])) return true;
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
