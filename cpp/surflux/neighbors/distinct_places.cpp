#include "surflux/neighbors/distinct_places.h"

#include "surflux/core/error.h"
#include "surflux/core/place_order.h"

namespace surflux {

DistinctPlaces distinct_places(const std::vector<Vec3>& points, const Progress& progress) {
    const Progress asked = standing_at(points.size(), points.size(), progress);
    constexpr std::size_t often = 1 << 20;
    for (std::size_t i = 0; i < points.size(); ++i)
        require(is_finite(points[i]), "points: wanted finite coordinates, got others at index ", i);
    const std::vector<std::uint32_t> order = place_order(points, progress);
    std::vector<std::uint32_t> first(points.size());  // of the points at the same place
    for (std::size_t k = 0; k < order.size(); ++k) {
        report_some(asked, k, order.size(), often);
        const bool known = k > 0 && points[order[k]] == points[order[k - 1]];
        first[order[k]] = known ? first[order[k - 1]] : order[k];
    }
    DistinctPlaces out;
    out.of_point.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        report_some(asked, i, points.size(), often);
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
