#include "surflux/meshless/point_grid.h"

#include <algorithm>

namespace surflux {

PointGrid::PointGrid(const Vec3& low, double side, std::size_t expected)
    : low_(low), side_(side), per_side_(1.0 / side) {
    std::size_t buckets = 64;
    while (buckets < expected) buckets *= 2;
    begin_.assign(buckets + 1, 0);
}

void PointGrid::insert(const std::vector<Point>& points) {
    const std::size_t buckets = begin_.size() - 1, before = points_.size(), n = points.size();
    std::vector<std::uint32_t> of_point(n), end(buckets + 1, 0), order(n);
    for (std::size_t k = 0; k < n; ++k) {
        const Cell c = cell_of(points[k].position);
        of_point[k] = static_cast<std::uint32_t>(bucket(c.at[1], c.at[2], c.at[0]));
        ++end[of_point[k] + 1];
    }
    for (std::size_t b = 0; b < buckets; ++b) end[b + 1] += end[b];
    for (std::uint32_t k = 0; k < n; ++k) order[end[of_point[k]]++] = k;  // end[b] is now where those of b end
    points_.resize(before + n);
    std::size_t still = before;  // points that have not moved
    for (std::size_t j = n; j-- > 0;) {
        const std::size_t from = begin_[of_point[order[j]] + 1];
        std::move_backward(points_.begin() + static_cast<std::ptrdiff_t>(from),
                           points_.begin() + static_cast<std::ptrdiff_t>(still),
                           points_.begin() + static_cast<std::ptrdiff_t>(still + j + 1));
        still = from;
        points_[from + j] = points[order[j]];
    }
    for (std::size_t b = 0; b < buckets; ++b) begin_[b + 1] += end[b];
}

const std::vector<PointGrid::Point>& Surroundings::of(const Vec3& place) {
    const PointGrid::Cell cell = grid_.cell_of(place);
    if (is_known_ && cell == cell_) return points_;
    is_known_ = true;
    cell_ = cell;
    points_.clear();
    // From the grid's corner, where numbers are small: far from the origin they are coarse.
    const double side = grid_.side(), far = 0.5 * side + reach_ * (1.0 + 1e-9);
    Vec3 center;
    for (int axis = 0; axis < 3; ++axis) center[axis] = (static_cast<double>(cell.at[axis]) + 0.5) * side;
    const auto out = static_cast<std::int64_t>(std::ceil(reach_ / side * (1.0 + 1e-9)));
    PointGrid::Cell from = cell, to = cell;
    for (int axis = 0; axis < 3; ++axis) from.at[axis] -= out, to.at[axis] += out;
    grid_.within(from, to, [&](const PointGrid::Point& p) {
        const Vec3 d = (p.position - grid_.low()) - center;
        if (std::abs(d.x) <= far && std::abs(d.y) <= far && std::abs(d.z) <= far) points_.push_back(p);
    });
    return points_;
}

}  // namespace surflux
