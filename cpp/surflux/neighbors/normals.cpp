#include "surflux/neighbors/normals.h"

#include <cmath>
#include <queue>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/neighbors/plane_fit.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

struct Edge {
    double weight;
    std::uint32_t from, to;
    bool operator<(const Edge& other) const {  // std::priority_queue takes the largest first
        if (weight != other.weight) return weight > other.weight;
        return to != other.to ? to > other.to : from > other.from;
    }
};

void orient_by_spanning_tree(const std::vector<Vec3>& points, const std::vector<std::vector<std::uint32_t>>& graph,
                             std::vector<Vec3>& normals) {
    std::vector<bool> done(points.size(), false);
    std::vector<std::uint32_t> component;
    for (std::size_t seed = 0; seed < points.size(); ++seed) {
        if (done[seed]) continue;
        component.clear();
        std::priority_queue<Edge> open;
        const auto visit = [&](std::uint32_t i) {
            done[i] = true;
            component.push_back(i);
            for (std::uint32_t j : graph[i])
                if (!done[j]) open.push({1.0 - std::abs(dot(normals[i], normals[j])), i, j});
        };
        visit(static_cast<std::uint32_t>(seed));
        while (!open.empty()) {
            const Edge edge = open.top();
            open.pop();
            if (done[edge.to]) continue;
            if (dot(normals[edge.from], normals[edge.to]) < 0.0) normals[edge.to] = -normals[edge.to];
            visit(edge.to);
        }
        Vec3 mean;
        for (std::uint32_t i : component) mean += points[i];
        mean *= 1.0 / static_cast<double>(component.size());
        double outward = 0.0;
        for (std::uint32_t i : component) outward += dot(points[i] - mean, normals[i]);
        if (outward < 0.0)
            for (std::uint32_t i : component) normals[i] = -normals[i];
    }
}

}  // namespace

std::vector<Vec3> estimate_normals(const std::vector<Vec3>& points, const NormalOptions& options,
                                   const Progress& progress) {
    require(points.size() >= 3, "normals: wanted at least 3 points to estimate them from, got ", points.size(),
            "; give normals");
    const PointIndex index(points);
    std::vector<Vec3> normals(points.size());
    std::vector<std::vector<std::uint32_t>> graph(points.size());
    parallel_blocks(
        points.size(), 256,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near;
            for (std::size_t i = begin; i < end; ++i) {
                // Duplicates and points on a line span no plane: look further until the neighbourhood does.
                for (std::size_t k = std::max<std::size_t>(options.neighbors, 3);; k *= 2) {
                    index.nearest(points[i], k, near);
                    normals[i] = plane_normal(points, near);
                    if (length_squared(normals[i]) > 0.0 || k >= points.size()) break;
                }
                for (const Neighbor& n : near)
                    if (n.index != i) graph[i].push_back(n.index);
            }
        },
        progress);
    for (std::size_t i = 0; i < points.size(); ++i)
        require(length_squared(normals[i]) > 0.0,
                "normals: the points lie on a line or coincide, so no surface can be fitted; give normals");
    if (options.viewpoint) {
        for (std::size_t i = 0; i < points.size(); ++i)
            if (dot(*options.viewpoint - points[i], normals[i]) < 0.0) normals[i] = -normals[i];
        return normals;
    }
    // Neighbourhood is not symmetric; the graph has to be, or the tree depends on where it starts.
    std::vector<std::size_t> own(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) own[i] = graph[i].size();
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t k = 0; k < own[i]; ++k) graph[graph[i][k]].push_back(static_cast<std::uint32_t>(i));
    orient_by_spanning_tree(points, graph, normals);
    return normals;
}

}  // namespace surflux
