#include "surflux/meshless/point_grid.h"

namespace surflux {

PointGrid::PointGrid(const Vec3& low, double side, std::size_t expected)
    : low_(low), side_(side), per_side_(1.0 / side) {
    std::size_t buckets = 64;
    while (buckets < expected) buckets *= 2;
    head_.assign(buckets, none);
    points_.reserve(expected);
}

void PointGrid::insert(const Vec3& position, const Vec3& normal, std::uint32_t index) {
    points_.push_back({position, normal, index, none});
    if (points_.size() <= head_.size()) return link(static_cast<std::uint32_t>(points_.size() - 1));
    head_.assign(2 * head_.size(), none);
    for (std::uint32_t k = 0; k < points_.size(); ++k) link(k);
}

void PointGrid::link(std::uint32_t k) {
    const Vec3& p = points_[k].position;
    std::uint32_t& head = head_[bucket(row_of(cell(p.y, 1), cell(p.z, 2)), cell(p.x, 0))];
    points_[k].next = head;
    head = k;
}

}  // namespace surflux
