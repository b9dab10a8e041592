#include "surflux/neighbors/radii.h"

#include <algorithm>
#include <cstdint>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

constexpr double outlier_ratio = 2.0;

}  // namespace

std::vector<double> estimate_radii(const std::vector<Vec3>& points, std::size_t neighbors) {
    require(points.size() >= 2, "radii: wanted at least 2 points to estimate them from, got ", points.size(),
            "; give radii");
    require(neighbors >= 1, "neighbors: wanted at least 1");
    const PointIndex index(points);
    std::vector<double> reach(points.size());
    std::vector<std::uint32_t> around(points.size() * neighbors);  // who is at those places; oneself where too few are
    parallel_blocks(points.size(), 256, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        std::vector<Vec3> places;
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t k = 2 * neighbors + 2;; k *= 2) {
                index.nearest(points[i], k, near);
                places.assign(1, points[i]);
                std::fill_n(around.begin() + static_cast<std::ptrdiff_t>(i * neighbors), neighbors,
                            static_cast<std::uint32_t>(i));
                for (const Neighbor& n : near) {
                    const Vec3& p = points[n.index];
                    if (std::find(places.begin(), places.end(), p) == places.end()) {
                        around[i * neighbors + places.size() - 1] = n.index;
                        places.push_back(p);
                    }
                    if (places.size() == neighbors + 1) break;
                }
                if (places.size() == neighbors + 1 || k >= points.size()) break;
            }
            reach[i] = length(places.back() - points[i]);
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
