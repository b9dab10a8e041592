#include "surflux/neighbors/distinct_places.h"

#include <algorithm>
#include <numeric>

#include "surflux/core/error.h"

namespace surflux {

DistinctPlaces distinct_places(const std::vector<Vec3>& points) {
    for (std::size_t i = 0; i < points.size(); ++i)
        require(is_finite(points[i]), "points: wanted finite coordinates, got others at index ", i);
    std::vector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
        const Vec3 &a = points[i], &b = points[j];
        if (a.x != b.x) return a.x < b.x;
        if (a.y != b.y) return a.y < b.y;
        return a.z != b.z ? a.z < b.z : i < j;
    });
    std::vector<std::uint32_t> first(points.size());  // of the points at the same place
    for (std::size_t k = 0; k < order.size(); ++k) {
        const bool known = k > 0 && points[order[k]] == points[order[k - 1]];
        first[order[k]] = known ? first[order[k - 1]] : order[k];
    }
    DistinctPlaces out;
    out.of_point.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (first[i] == i) {
            out.of_point[i] = static_cast<std::uint32_t>(out.places.size());
            out.places.push_back(points[i]);
        } else {
            out.of_point[i] = out.of_point[first[i]];
        }
    }
    return out;
}

}  // namespace surflux
