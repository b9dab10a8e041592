#include "surflux/meshless/point_grid.h"

#include <algorithm>

namespace surflux {

PointGrid::PointGrid(const std::vector<Point>& points, const std::vector<double>& radius)
    : radius_(radius), points_(points.size()) {
    if (!points.empty()) low_ = points[0].position;
    for (const Point& p : points)
        for (int axis = 0; axis < 3; ++axis) low_[axis] = std::min(low_[axis], p.position[axis]);
    std::size_t buckets = 64;
    while (buckets < points.size()) buckets *= 2;
    begin_.assign(buckets + 1, 0);
    std::vector<std::uint32_t> of_point;
    of_point.reserve(points.size());
    for (const Point& p : points) {
        of_point.push_back(static_cast<std::uint32_t>(bucket(cell_of(p.position - low_, p.object), p.object)));
        ++begin_[of_point.back()];
    }
    for (std::size_t b = 0; b < buckets; ++b) begin_[b + 1] += begin_[b];
    for (std::size_t k = points.size(); k-- > 0;) points_[--begin_[of_point[k]]] = points[k];
}

}  // namespace surflux
