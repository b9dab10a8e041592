#include "surflux/neighbors/distinct_places.h"

#include <algorithm>
#include <utility>

#include "surflux/core/error.h"

namespace surflux {

DistinctPlaces distinct_places(const std::vector<Vec3>& points) {
    for (std::size_t i = 0; i < points.size(); ++i)
        require(is_finite(points[i]), "points: wanted finite coordinates, got others at index ", i);
    std::vector<std::pair<Vec3, std::uint32_t>> sorted(
        points.size());  // with the positions: sorting finds them near by
    for (std::uint32_t i = 0; i < points.size(); ++i) sorted[i] = {points[i], i};
    std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
        if (a.first.x != b.first.x) return a.first.x < b.first.x;
        if (a.first.y != b.first.y) return a.first.y < b.first.y;
        return a.first.z != b.first.z ? a.first.z < b.first.z : a.second < b.second;
    });
    std::vector<std::uint32_t> first(points.size());  // of the points at the same place
    for (std::size_t k = 0; k < sorted.size(); ++k) {
        const bool known = k > 0 && sorted[k].first == sorted[k - 1].first;
        first[sorted[k].second] = known ? first[sorted[k - 1].second] : sorted[k].second;
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
