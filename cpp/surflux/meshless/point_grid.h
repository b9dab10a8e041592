#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// A spatial hash of points for searches within a radius that each object has of its own: in cubic cells of twice that.
class PointGrid {
public:
    struct Point {
        Vec3 position, normal;
        std::uint32_t object, surfel = 0;
        std::uint64_t priority = 0;
    };

    // `radius`: of each object.
    PointGrid(const std::vector<Point>& points, const std::vector<double>& radius);

    // Is there a point of the object closer than the object's radius for which test(point) holds?
    template <class Test>
    bool any_near(const Vec3& place, std::uint32_t object, const Test& test) const {
        const double r = radius_[object];
        const Vec3 reach = Vec3{r, r, r} * (1.0 + 1e-9);
        const Cell from = cell_of(place - low_ - reach, object), to = cell_of(place - low_ + reach, object);
        for (std::int64_t z = from.z; z <= to.z; ++z)
            for (std::int64_t y = from.y; y <= to.y; ++y)
                for (std::int64_t x = from.x; x <= to.x; ++x) {
                    const std::size_t b = bucket({x, y, z}, object);
                    for (std::size_t k = begin_[b]; k < begin_[b + 1]; ++k) {
                        const Point& p = points_[k];
                        if (p.object == object && length_squared(p.position - place) < r * r && test(p)) return true;
                    }
                }
        return false;
    }

private:
    struct Cell {
        std::int64_t x, y, z;
    };
    // Of a place from the grid's corner, where numbers are small: far from the origin they are coarse.
    Cell cell_of(const Vec3& from_low, std::uint32_t object) const {
        const Vec3 p = from_low * (0.5 / radius_[object]);
        return {static_cast<std::int64_t>(std::floor(p.x)), static_cast<std::int64_t>(std::floor(p.y)),
                static_cast<std::int64_t>(std::floor(p.z))};
    }
    // Multiplicative hashing by odd 64-bit constants (2^64 over the golden ratio, and primes), whose high bits are well
    // mixed. The mask is the number of buckets minus 1.
    std::size_t bucket(const Cell& c, std::uint32_t object) const {
        const std::uint64_t key = static_cast<std::uint64_t>(c.x) * 0x9e3779b97f4a7c15ull +
                                  static_cast<std::uint64_t>(c.y) * 0xc2b2ae3d27d4eb4full +
                                  static_cast<std::uint64_t>(c.z) * 0x165667b19e3779f9ull + object;
        return (key >> 32) & (begin_.size() - 2);
    }

    std::vector<double> radius_;
    Vec3 low_;
    std::vector<std::uint32_t> begin_;  // of each bucket, a power of two of them, and the end
    std::vector<Point> points_;
};

}  // namespace surflux
