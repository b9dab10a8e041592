#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include "surflux/core/parallel.h"
#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

struct PlaceAndNormal {
    Vec3 position, normal;
};

// Indices in an order in which ranges of them are halved by position and normal.
class Bisection {
public:
    // A unit of the normal is as long as `normal_weight` times the longest side of the box around positions.
    Bisection(std::size_t count, double normal_weight) : order(count), key_(count), normal_weight_(normal_weight) {
        std::iota(order.begin(), order.end(), 0u);
    }

    // Halves a range across the longest side of the box around its positions and normals: puts one half first, and
    // returns where the other begins. `place`: the PlaceAndNormal of an index, asked on many threads at once.
    template <class Place>
    std::size_t halve(std::size_t first, std::size_t last, const Place& place, const Progress& progress = {}) {
        constexpr double infinite = std::numeric_limits<double>::infinity();
        double least[6], most[6];
        std::fill_n(least, 6, infinite);
        std::fill_n(most, 6, -infinite);
        for (std::size_t k = first; k < last; ++k) {
            const PlaceAndNormal of = place(order[k]);
            for (int axis = 0; axis < 6; ++axis) {
                const double at = axis < 3 ? of.position[axis] : of.normal[axis - 3];
                least[axis] = std::min(least[axis], at);
                most[axis] = std::max(most[axis], at);
            }
            report_some(progress, k - first, last - first, 1 << 20);
        }
        double extent = 0.0;
        for (int axis = 0; axis < 3; ++axis) extent = std::max(extent, most[axis] - least[axis]);
        int widest = 0;
        double width = -1.0;
        for (int axis = 0; axis < 6; ++axis)
            if (const double w = (axis < 3 ? 1.0 : normal_weight_ * extent) * (most[axis] - least[axis]); w > width)
                width = w, widest = axis;
        const auto find_key = [&](std::size_t k) {
            const PlaceAndNormal of = place(order[first + k]);
            key_[order[first + k]] = widest < 3 ? of.position[widest] : of.normal[widest - 3];
        };
        parallel_for(last - first, 4096, find_key, progress);
        const std::size_t middle = first + (last - first) / 2;
        const auto at = [&](std::size_t k) { return order.begin() + static_cast<std::ptrdiff_t>(k); };
        std::nth_element(at(first), at(middle), at(last), [&](std::uint32_t a, std::uint32_t b) {
            return key_[a] < key_[b] || (key_[a] == key_[b] && a < b);
        });
        report(progress, 0, 1);
        return middle;
    }

    std::vector<std::uint32_t> order;

private:
    std::vector<double> key_;  // what was halved by last, of each index
    double normal_weight_;
};

}  // namespace surflux
