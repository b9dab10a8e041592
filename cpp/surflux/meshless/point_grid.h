#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// A spatial hash of points with normals: buckets of cubic cells, those along x one after the other. On a collision the
// points of other cells come along, and may come twice: callers test distances anyway.
class PointGrid {
public:
    struct Point {
        Vec3 position, normal;
        std::uint32_t index;
    };
    struct Cell {
        std::int64_t at[3];
        bool operator==(const Cell& c) const { return at[0] == c.at[0] && at[1] == c.at[1] && at[2] == c.at[2]; }
    };

    PointGrid(const Vec3& low, double side, std::size_t expected);

    // All in one go: what is there is moved.
    void insert(const std::vector<Point>& points);

    const Vec3& low() const { return low_; }
    double side() const { return side_; }
    Cell cell_of(const Vec3& p) const { return {{cell(p.x, 0), cell(p.y, 1), cell(p.z, 2)}}; }

    // Calls visit(point) for all points of the cells from one corner to the opposite one, and for some others.
    template <class Visit>
    void within(const Cell& from, const Cell& to, const Visit& visit) const {
        const auto scan = [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin_[begin]; k < begin_[end]; ++k) visit(points_[k]);
        };
        const std::size_t buckets = begin_.size() - 1;
        const auto wide = static_cast<std::uint64_t>(to.at[0] - from.at[0]) + 1;
        for (std::int64_t z = from.at[2]; z <= to.at[2]; ++z)
            for (std::int64_t y = from.at[1]; y <= to.at[1]; ++y) {
                if (wide >= buckets) return scan(0, buckets);
                const std::size_t first = bucket(y, z, from.at[0]), last = first + static_cast<std::size_t>(wide);
                scan(first, last < buckets ? last : buckets);
                if (last > buckets) scan(0, last - buckets);
            }
    }

private:
    std::int64_t cell(double x, int axis) const {
        return static_cast<std::int64_t>(std::floor((x - low_[axis]) * per_side_));
    }
    // Multiplicative hashing of y and z by odd 64-bit constants (2^64 over the golden ratio, and a prime), whose high
    // bits are well mixed; x is added after that, so that cells along x stay adjacent. The mask is the number of
    // buckets minus 1.
    std::size_t bucket(std::int64_t y, std::int64_t z, std::int64_t x) const {
        const std::uint64_t row = static_cast<std::uint64_t>(y) * 0x9e3779b97f4a7c15ull +
                                  static_cast<std::uint64_t>(z) * 0xc2b2ae3d27d4eb4full;
        return ((row >> 32) + static_cast<std::uint64_t>(x)) & (begin_.size() - 2);
    }

    Vec3 low_;
    double side_, per_side_;
    std::vector<std::uint32_t> begin_;  // of each bucket, a power of two of them, and the end
    std::vector<Point> points_;
};

// The points around places, for places that come mostly near the one before: those around a whole cell are kept.
class Surroundings {
public:
    Surroundings(const PointGrid& grid, double reach) : grid_(grid), reach_(reach) {}

    // All points within reach of the place, and some more.
    const std::vector<PointGrid::Point>& of(const Vec3& place);

private:
    const PointGrid& grid_;
    double reach_;
    bool is_known_ = false;
    PointGrid::Cell cell_{};
    std::vector<PointGrid::Point> points_;
};

}  // namespace surflux
