#include "surflux/meshless/conflict_graph.h"

#include <algorithm>
#include <numeric>

#include "surflux/core/parallel.h"

namespace surflux {

ConflictGraph::ConflictGraph(const std::vector<Proposal>& proposals, const Fill& fill, const PointGrid& grid)
    : order(proposals.size()), lists_((order.size() + block - 1) / block), begin_(order.size()), end_(order.size()) {
    const auto normal_of = [&](std::size_t k) { return fill.scene.surfels.normals[proposals[k].surfel]; };
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
        return proposals[a].priority != proposals[b].priority ? proposals[a].priority < proposals[b].priority : a < b;
    };
    PointGrid all(grid.low(), grid.side(), order.size());
    std::vector<PointGrid::Point> points(order.size());
    for (std::uint32_t k = 0; k < points.size(); ++k) points[k] = {proposals[k].position, normal_of(k), k};
    all.insert(points);
    points = {};
    parallel_blocks(order.size(), block, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t>& list = lists_[begin / block];
        Surroundings near(all, fill.radius);
        for (std::size_t k = begin; k < end; ++k) {
            const Vec3 at = proposals[k].position, normal = normal_of(k);
            begin_[k] = static_cast<std::uint32_t>(list.size());
            for (const PointGrid::Point& q : near.of(at)) {
                if (length_squared(q.position - at) >= fill.radius * fill.radius) continue;
                const KeptDisk disk{q.position, fill.radius * std::max(0.0, dot(normal, q.normal))};
                if (disk.holds(at) && before(q.index, static_cast<std::uint32_t>(k))) list.push_back(q.index);
            }
            end_[k] = static_cast<std::uint32_t>(list.size());
        }
    });
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), before);
}

}  // namespace surflux
