#include "surflux/neighbors/radii.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/neighbors/plane_fit.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

constexpr double open_angle = 2.0 * pi / 3.0;
constexpr double outlier_ratio = 2.0;

// The nearest `count` neighbours of point i that are at places of their own, nearest first; fewer where there are none.
void distinct_neighbors(const PointIndex& index, const std::vector<Vec3>& points, std::size_t i, std::size_t count,
                        std::vector<Neighbor>& out) {
    std::vector<Neighbor> near;
    for (std::size_t k = count + 3;; k *= 2) {
        index.nearest(points[i], k, near);
        out.clear();
        for (const Neighbor& n : near) {
            const Vec3& p = points[n.index];
            const bool known = p == points[i] || std::any_of(out.begin(), out.end(), [&](const Neighbor& other) {
                                   return points[other.index] == p;
                               });
            if (!known) out.push_back(n);
            if (out.size() == count) return;
        }
        if (k >= points.size()) return;
    }
}

// Do the directions to the first `count` neighbours, seen along `normal`, leave no angle open?
bool surrounded(const std::vector<Vec3>& points, std::size_t i, const std::vector<Neighbor>& near, std::size_t count,
                const Frame& frame) {
    std::vector<double> angles;
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3 d = points[near[k].index] - points[i];
        angles.push_back(std::atan2(dot(d, frame.v), dot(d, frame.u)));
    }
    std::sort(angles.begin(), angles.end());
    double widest = angles.front() + 2.0 * pi - angles.back();
    for (std::size_t k = 1; k < angles.size(); ++k) widest = std::max(widest, angles[k] - angles[k - 1]);
    return widest <= open_angle;
}

}  // namespace

std::vector<double> estimate_radii(const std::vector<Vec3>& points, std::size_t neighbors) {
    require(points.size() >= 2, "radii: wanted at least 2 points to estimate them from, got ", points.size(),
            "; give radii");
    require(neighbors >= 1, "neighbors: wanted at least 1");
    const PointIndex index(points);
    std::vector<double> reach(points.size(), 0.0);
    std::vector<std::uint32_t> around(points.size() * neighbors);  // the neighbours; oneself where there are too few
    parallel_blocks(points.size(), 256, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t i = begin; i < end; ++i) {
            distinct_neighbors(index, points, i, 3 * neighbors, near);
            if (near.empty()) continue;
            const std::size_t first = std::min(neighbors, near.size());
            std::size_t taken = first;
            const Vec3 normal = plane_normal(points, near);
            if (length_squared(normal) > 0.0) {
                const Frame frame = frame_around(normal);
                while (taken <= near.size() && !surrounded(points, i, near, taken, frame)) ++taken;
                if (taken > near.size()) taken = first;
            }
            reach[i] = length(points[near[taken - 1].index] - points[i]);
            for (std::size_t k = 0; k < neighbors; ++k)
                around[i * neighbors + k] = k < near.size() ? near[k].index : static_cast<std::uint32_t>(i);
        }
    });
    require(*std::max_element(reach.begin(), reach.end()) > 0.0, "radii: all points coincide; give radii");
    std::vector<double> radii(points.size());
    parallel_blocks(points.size(), 1024, [&](std::size_t begin, std::size_t end) {
        std::vector<double> theirs(neighbors);
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t k = 0; k < neighbors; ++k) theirs[k] = reach[around[i * neighbors + k]];
            const auto middle = theirs.begin() + static_cast<std::ptrdiff_t>(neighbors / 2);
            std::nth_element(theirs.begin(), middle, theirs.end());
            radii[i] = std::min(reach[i], outlier_ratio * *middle);
        }
    });
    return radii;
}

}  // namespace surflux
