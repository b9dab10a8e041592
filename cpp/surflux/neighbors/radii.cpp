#include "surflux/neighbors/radii.h"

#include <algorithm>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

std::vector<double> estimate_radii(const std::vector<Vec3>& points, std::size_t neighbors) {
    require(points.size() >= 2, "radii: wanted at least 2 points to estimate them from, got ", points.size(),
            "; give radii");
    require(neighbors >= 1, "neighbors: wanted at least 1");
    const PointIndex index(points);
    std::vector<double> radii(points.size());
    parallel_blocks(points.size(), 256, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        std::vector<Vec3> places;
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t k = 2 * neighbors + 2;; k *= 2) {
                index.nearest(points[i], k, near);
                places.assign(1, points[i]);
                for (const Neighbor& n : near) {
                    const Vec3& p = points[n.index];
                    if (std::find(places.begin(), places.end(), p) == places.end()) places.push_back(p);
                    if (places.size() == neighbors + 1) break;
                }
                if (places.size() == neighbors + 1 || k >= points.size()) break;
            }
            radii[i] = length(places.back() - points[i]);
        }
    });
    require(*std::max_element(radii.begin(), radii.end()) > 0.0, "radii: all points coincide; give radii");
    return radii;
}

}  // namespace surflux
