#include "surflux/meshless/refined_region.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "surflux/meshless/point_grid.h"

namespace surflux {

SignedDistance refined_region(const MultilevelBasis& basis, const std::vector<std::uint32_t>& functions,
                              const std::vector<double>& first_radius, double placed_reach) {
    std::vector<double> reach, twice;
    for (const double first : first_radius) {
        reach.push_back(placed_reach * std::ldexp(first, -static_cast<int>(basis.levels())));
        twice.push_back(2.0 * reach.back());
    }
    std::vector<PointGrid::Point> centers;
    for (const std::uint32_t j : functions) centers.push_back({basis.position(j), basis.normal(j), basis.object(j)});
    const auto grid = std::make_shared<PointGrid>(centers, twice);
    return [grid, reach](const Vec3& place, const Vec3& normal, std::uint32_t object) {
        double least = reach[object];
        grid->any_near(place, object, [&](const PointGrid::Point& p) {
            if (dot(p.normal, normal) > 0.0) least = std::min(least, length(p.position - place) - reach[object]);
            return least <= 0.0;
        });
        return least;
    };
}

std::vector<std::uint32_t> children_of(const MultilevelBasis& basis, const std::vector<std::uint32_t>& parents) {
    const std::size_t level = basis.levels() - 1;
    std::vector<char> is_child(basis.size() - basis.first(level), 0);
    std::vector<BasisWeight> near;
    for (const std::uint32_t j : parents) {
        basis.at_level(level, basis.position(j), basis.normal(j), basis.object(j), near);
        for (const BasisWeight& w : near) is_child[w.function - basis.first(level)] = 1;
    }
    std::vector<std::uint32_t> out;
    for (std::uint32_t k = 0; k < is_child.size(); ++k)
        if (is_child[k]) out.push_back(basis.first(level) + k);
    return out;
}

}  // namespace surflux
