#include "surflux/core/morton.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

// 21 bits with two zeros between each and the next.
std::uint64_t spread(std::uint64_t v) {
    v &= 0x1fffff;  // each step moves the upper half of every run of bits up, by twice that half's length
    v = (v | v << 32) & 0x1f00000000ffffull;
    v = (v | v << 16) & 0x1f0000ff0000ffull;
    v = (v | v << 8) & 0x100f00f00f00f00full;
    v = (v | v << 4) & 0x10c30c30c30c30c3ull;
    return (v | v << 2) & 0x1249249249249249ull;
}

}  // namespace

std::vector<std::uint32_t> morton_order(const std::vector<Vec3>& points, const Progress& progress) {
    std::vector<std::uint32_t> order(points.size());
    if (points.empty()) return order;
    Vec3 low = points[0], high = points[0];
    for (const Vec3& p : points)
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], p[axis]);
            high[axis] = std::max(high[axis], p[axis]);
        }
    const Vec3 span = high - low;
    const double side = std::max({span.x, span.y, span.z, 1e-300});
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(points.size());
    parallel_for(points.size(), 4096, [&](std::size_t i) {
        std::uint64_t key = 0;
        for (int axis = 0; axis < 3; ++axis)
            key |= spread(static_cast<std::uint64_t>((points[i][axis] - low[axis]) / side * 2097151.0)) << axis;
        keys[i] = {key, static_cast<std::uint32_t>(i)};
    });
    parallel_sort(keys, std::less<>(), progress);
    for (std::size_t k = 0; k < keys.size(); ++k) order[k] = keys[k].second;
    return order;
}

}  // namespace surflux
