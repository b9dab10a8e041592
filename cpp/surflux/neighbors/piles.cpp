#include "surflux/neighbors/piles.h"

#include <algorithm>

#include "surflux/neighbors/distinct_places.h"
#include "surflux/neighbors/sheet_index.h"

namespace surflux {

std::vector<std::vector<std::uint32_t>> find_piles(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                                                   const std::vector<double>& radii, double epsilon,
                                                   const Progress& progress) {
    std::vector<std::vector<std::uint32_t>> piles;
    const DistinctPlaces distinct = distinct_places(positions, progress);
    if (distinct.places.size() == positions.size()) return piles;
    std::vector<std::uint32_t> count(distinct.places.size(), 0);
    for (const std::uint32_t place : distinct.of_point) ++count[place];
    std::vector<std::uint32_t> shared, group;  // points that share their place, and which place that is
    std::vector<Vec3> places, facing;
    for (std::uint32_t i = 0; i < positions.size(); ++i) {
        if (count[distinct.of_point[i]] < 2) continue;
        shared.push_back(i);
        group.push_back(distinct.of_point[i]);
        places.push_back(positions[i]);
        facing.push_back(normals[i]);
    }
    SheetIndex index(places, facing, std::vector<double>(shared.size(), 1.0), group, epsilon);
    for (std::uint32_t k = 0; k < shared.size(); ++k) {
        if (index.is_taken(k)) continue;
        std::vector<std::uint32_t> pile;
        index.take(k, pile);
        if (pile.size() < 2) continue;
        for (std::uint32_t& member : pile) member = shared[member];
        std::sort(pile.begin(), pile.end(),
                  [&](std::uint32_t a, std::uint32_t b) { return radii[a] != radii[b] ? radii[a] < radii[b] : a < b; });
        std::rotate(pile.begin(), pile.begin() + static_cast<std::ptrdiff_t>(pile.size() / 2), pile.end());
        piles.push_back(std::move(pile));
    }
    return piles;
}

}  // namespace surflux
