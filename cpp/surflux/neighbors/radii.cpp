#include "surflux/neighbors/radii.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/neighbors/distinct_places.h"
#include "surflux/neighbors/plane_fit.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

constexpr double open_angle = 2.0 * pi / 3.0;
constexpr double outlier_ratio = 2.0;

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

// Of points no two of which coincide; 1 <= neighbors < points.size().
std::vector<double> radii_of(const std::vector<Vec3>& points, std::size_t neighbors, const Progress& progress) {
    const PointIndex index(points);
    std::vector<double> reach(points.size());
    std::vector<std::uint32_t> around(points.size() * neighbors);
    parallel_blocks(
        points.size(), 256,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near;
            for (std::size_t i = begin; i < end; ++i) {
                index.nearest(points[i], 3 * neighbors + 1, near);
                near.erase(std::find_if(near.begin(), near.end(), [i](const Neighbor& n) { return n.index == i; }));
                std::size_t taken = neighbors;
                const Vec3 normal = plane_normal(points, near);
                if (length_squared(normal) > 0.0) {
                    const Frame frame = frame_around(normal);
                    while (taken <= near.size() && !surrounded(points, i, near, taken, frame)) ++taken;
                    if (taken > near.size()) taken = neighbors;
                }
                reach[i] = length(points[near[taken - 1].index] - points[i]);
                for (std::size_t k = 0; k < neighbors; ++k) around[i * neighbors + k] = near[k].index;
            }
        },
        progress);
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

}  // namespace

std::vector<double> estimate_radii(const std::vector<Vec3>& points, std::size_t neighbors, const Progress& progress) {
    require(points.size() >= 2, "radii: wanted at least 2 points to estimate them from, got ", points.size(),
            "; give radii");
    require(neighbors >= 1, "neighbors: wanted at least 1");
    const auto [places, of_point] = distinct_places(points);
    require(places.size() >= 2, "radii: all points coincide; give radii");
    neighbors = std::min(neighbors, places.size() - 1);
    const std::vector<double> radii = radii_of(places, neighbors, progress);
    std::vector<double> out(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) out[i] = radii[of_point[i]];
    return out;
}

}  // namespace surflux
