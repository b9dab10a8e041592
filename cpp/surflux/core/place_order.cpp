#include "surflux/core/place_order.h"

#include <algorithm>
#include <cstring>
#include <functional>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

// The upper 32 bits of xor-shift and multiplication by 2^64 over the golden ratio.
std::uint64_t hash_of(const Vec3& p) {
    std::uint64_t bits = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double coordinate = p[axis] + 0.0;  // -0 is 0
        std::uint64_t word = 0;
        std::memcpy(&word, &coordinate, sizeof word);
        bits = (bits ^ (bits >> 29) ^ word) * 0x9e3779b97f4a7c15ull;
    }
    return (bits ^ (bits >> 29)) * 0x9e3779b97f4a7c15ull >> 32;
}

}  // namespace

std::vector<std::uint32_t> place_order(const std::vector<Vec3>& points, const Progress& progress) {
    // Numbers sort in a third of the memory and a fraction of the time that places do.
    std::vector<std::uint64_t> keys(points.size());
    parallel_for(points.size(), 4096, [&](std::size_t i) { keys[i] = hash_of(points[i]) << 32 | i; }, progress);
    parallel_sort(keys, std::less<>(), progress);
    std::vector<std::uint32_t> order(points.size());
    for (std::size_t k = 0; k < keys.size(); ++k) order[k] = static_cast<std::uint32_t>(keys[k]);
    const Progress asked = standing_at(points.size(), points.size(), progress);
    // Other places may have the same hash.
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
        const Vec3 &p = points[a], &q = points[b];
        if (p.x != q.x) return p.x < q.x;
        if (p.y != q.y) return p.y < q.y;
        return p.z != q.z ? p.z < q.z : a < b;
    };
    std::size_t told = 0;
    for (std::size_t first = 0, last; first < keys.size(); first = last) {
        if (first >= told + (1 << 20)) report(asked, told = first, keys.size());
        for (last = first + 1; last < keys.size() && keys[last] >> 32 == keys[first] >> 32;) ++last;
        if (last - first > 1)
            std::sort(order.begin() + static_cast<std::ptrdiff_t>(first),
                      order.begin() + static_cast<std::ptrdiff_t>(last), before);
    }
    report(progress, points.size(), points.size());
    return order;
}

}  // namespace surflux
