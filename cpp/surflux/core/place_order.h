#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "surflux/core/parallel.h"
#include "surflux/core/vec.h"

namespace surflux {

// The points' indices in lexicographic order of x, y and z, those at one place by index: points that coincide stand
// together.
inline std::vector<std::uint32_t> place_order(const std::vector<Vec3>& points) {
    std::vector<std::pair<Vec3, std::uint32_t>> sorted(points.size());  // sorting finds the positions near by
    for (std::uint32_t i = 0; i < points.size(); ++i) sorted[i] = {points[i], i};
    parallel_sort(sorted, [](const auto& a, const auto& b) {
        if (a.first.x != b.first.x) return a.first.x < b.first.x;
        if (a.first.y != b.first.y) return a.first.y < b.first.y;
        return a.first.z != b.first.z ? a.first.z < b.first.z : a.second < b.second;
    });
    std::vector<std::uint32_t> out;
    out.reserve(points.size());
    for (const auto& [point, index] : sorted) out.push_back(index);
    return out;
}

}  // namespace surflux
