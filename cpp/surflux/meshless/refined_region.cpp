#include "surflux/meshless/refined_region.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "surflux/meshless/point_grid.h"

namespace surflux {

namespace {

// Points of a level are placed within this many of its Poisson radii of a receiver that is refined: its children, of
// which the supports reach it, lie within about 2.1, and whose supports reach theirs hold them down to 0 at the rim.
constexpr double placed_reach = 4.4;

}  // namespace

Wanted wanted_around(const MultilevelBasis& basis, const std::vector<std::uint32_t>& functions,
                     const std::vector<double>& first_radius) {
    struct Region {
        std::vector<PointGrid> grids;  // of each object
        std::vector<double> reach;
    };
    const auto region = std::make_shared<Region>();
    std::vector<std::vector<PointGrid::Point>> of_object(first_radius.size());
    Vec3 low = functions.empty() ? Vec3{} : basis.position(functions[0]);
    for (const std::uint32_t j : functions) {
        of_object[basis.object(j)].push_back({basis.position(j), basis.normal(j), j});
        for (int axis = 0; axis < 3; ++axis) low[axis] = std::min(low[axis], basis.position(j)[axis]);
    }
    for (std::size_t o = 0; o < first_radius.size(); ++o) {
        region->reach.push_back(placed_reach * std::ldexp(first_radius[o], -static_cast<int>(basis.levels())));
        region->grids.emplace_back(low, std::max(region->reach[o], 1e-300), of_object[o].size() + 1);
        region->grids[o].insert(of_object[o]);
    }
    return [region](const Vec3& p, const Vec3& n, std::uint32_t o) {
        const PointGrid& grid = region->grids[o];
        const double r = region->reach[o];
        bool near = false;
        grid.within(grid.cell_of(p - Vec3{r, r, r}), grid.cell_of(p + Vec3{r, r, r}),
                    [&](const PointGrid::Point& other) {
                        near = near || (length_squared(other.position - p) < r * r && dot(other.normal, n) > 0.0);
                    });
        return near;
    };
}

}  // namespace surflux
