#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// Points with normals in cubic cells, found by a hash of the cell. Those of other cells that share a bucket come along,
// and may come twice: who asks looks at distances anyway.
class PointGrid {
public:
    struct Point {
        Vec3 position, normal;
        std::uint32_t index, next;
    };

    PointGrid(const Vec3& low, double side, std::size_t expected);

    void insert(const Vec3& position, const Vec3& normal, std::uint32_t index);
    const Vec3& low() const { return low_; }
    double side() const { return side_; }

    // Calls visit(point) for all points of the cells that a ball touches, and for some others.
    template <class Visit>
    void around(const Vec3& center, double radius, const Visit& visit) const {
        std::int64_t from[3], to[3];
        for (int axis = 0; axis < 3; ++axis) {
            from[axis] = cell(center[axis] - radius, axis);
            to[axis] = cell(center[axis] + radius, axis);
        }
        for (std::int64_t z = from[2]; z <= to[2]; ++z)
            for (std::int64_t y = from[1]; y <= to[1]; ++y) {
                const std::uint64_t row = row_of(y, z);
                for (std::int64_t x = from[0]; x <= to[0]; ++x)
                    for (std::uint32_t k = head_[bucket(row, x)]; k != none; k = points_[k].next)
                        visit(points_[k]);
            }
    }

private:
    static constexpr std::uint32_t none = 0xffffffffu;

    std::int64_t cell(double x, int axis) const {
        return static_cast<std::int64_t>(std::floor((x - low_[axis]) * per_side_));
    }
    static std::uint64_t row_of(std::int64_t y, std::int64_t z) {
        return static_cast<std::uint64_t>(y) * 0x9e3779b97f4a7c15ull +
               static_cast<std::uint64_t>(z) * 0xc2b2ae3d27d4eb4full;
    }
    // Cells in a row have buckets in a row.
    std::size_t bucket(std::uint64_t row, std::int64_t x) const {
        return ((row >> 32) + static_cast<std::uint64_t>(x)) & (head_.size() - 1);
    }
    void link(std::uint32_t k);

    Vec3 low_;
    double side_, per_side_;
    std::vector<std::uint32_t> head_;
    std::vector<Point> points_;
};

}  // namespace surflux
