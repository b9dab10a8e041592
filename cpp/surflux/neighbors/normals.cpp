#include "surflux/neighbors/normals.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/neighbors/distinct_places.h"
#include "surflux/neighbors/plane_fit.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

using Graph = std::vector<std::vector<std::uint32_t>>;

// How many times the neighbours asked for a place may look at before it takes its normal from another one.
constexpr std::size_t farthest_look = 16;

struct Edge {
    double weight;
    std::uint32_t from, to;
    bool operator<(const Edge& other) const {  // std::priority_queue takes the largest first
        if (weight != other.weight) return weight > other.weight;
        return to != other.to ? to > other.to : from > other.from;
    }
};

Vec3 median(const std::vector<Vec3>& points, const std::vector<std::uint32_t>& members) {
    Vec3 out;
    std::vector<double> values(members.size());
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(members.size() / 2);
    for (int axis = 0; axis < 3; ++axis) {
        std::transform(members.begin(), members.end(), values.begin(),
                       [&](std::uint32_t i) { return points[i][axis]; });
        std::nth_element(values.begin(), middle, values.end());
        out[axis] = *middle;
    }
    return out;
}

void orient_by_spanning_tree(const std::vector<Vec3>& points, const Graph& graph, std::vector<Vec3>& normals) {
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
        // Not the mean and not the vectors themselves: one outlier would outweigh all the others.
        const Vec3 center = median(points, component);
        double outward = 0.0;
        for (std::uint32_t i : component) {
            const Vec3 d = points[i] - center;
            if (length_squared(d) > 0.0) outward += dot(normalized(d), normals[i]);
        }
        if (outward < 0.0)
            for (std::uint32_t i : component) normals[i] = -normals[i];
    }
}

// Unoriented normals of places of their own, and who is next to whom.
std::vector<Vec3> fitted_normals(const std::vector<Vec3>& places, std::size_t neighbors, Graph& graph,
                                 const Progress& progress) {
    const PointIndex index(places);
    std::vector<Vec3> normals(places.size());
    parallel_blocks(
        places.size(), 256,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near;
            for (std::size_t i = begin; i < end; ++i) {
                // Places on a line span no plane: look further until the neighbourhood does, but not at all there are.
                std::size_t k = neighbors;
                for (;; k *= 2) {
                    index.nearest(places[i], k, near);
                    normals[i] = plane_normal(places, near);
                    if (length_squared(normals[i]) > 0.0 || k >= places.size() || 2 * k > farthest_look * neighbors)
                        break;
                }
                if (!(length_squared(normals[i]) > 0.0)) near.resize(std::min(near.size(), neighbors));
                for (const Neighbor& n : near)
                    if (n.index != i) graph[i].push_back(n.index);
            }
        },
        progress);

    std::vector<std::uint32_t> with, without;
    for (std::uint32_t i = 0; i < places.size(); ++i) (length_squared(normals[i]) > 0.0 ? with : without).push_back(i);
    if (without.empty()) return normals;
    if (with.empty()) {
        std::vector<Neighbor> all;
        for (std::uint32_t i = 0; i < places.size(); ++i) all.push_back({i, 0.0});
        const Vec3 normal = plane_normal(places, all);
        require(length_squared(normal) > 0.0,
                "normals: the points lie on a line or coincide, so no surface can be fitted; give normals");
        normals.assign(places.size(), normal);
        return normals;
    }
    std::vector<Vec3> fitted;
    for (std::uint32_t i : with) fitted.push_back(places[i]);
    const PointIndex fitted_index(fitted);
    parallel_blocks(without.size(), 256, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t k = begin; k < end; ++k) {
            const std::uint32_t i = without[k];
            fitted_index.nearest(places[i], 1, near);
            const std::uint32_t giver = with[near[0].index];
            normals[i] = normals[giver];
            graph[i].push_back(giver);
        }
    });
    return normals;
}

}  // namespace

std::vector<Vec3> estimate_normals(const std::vector<Vec3>& points, const NormalOptions& options,
                                   const Progress& progress) {
    require(points.size() >= 3, "normals: wanted at least 3 points to estimate them from, got ", points.size(),
            "; give normals");
    const auto [places, of_point] = distinct_places(points);
    Graph graph(places.size());
    std::vector<Vec3> normals = fitted_normals(places, std::max<std::size_t>(options.neighbors, 3), graph, progress);
    if (options.viewpoint) {
        for (std::size_t i = 0; i < places.size(); ++i)
            if (dot(*options.viewpoint - places[i], normals[i]) < 0.0) normals[i] = -normals[i];
    } else {
        // Neighbourhood is not symmetric; the graph has to be, or the tree depends on where it starts.
        std::vector<std::size_t> own(places.size());
        for (std::size_t i = 0; i < places.size(); ++i) own[i] = graph[i].size();
        for (std::size_t i = 0; i < places.size(); ++i)
            for (std::size_t k = 0; k < own[i]; ++k) graph[graph[i][k]].push_back(static_cast<std::uint32_t>(i));
        orient_by_spanning_tree(places, graph, normals);
    }
    std::vector<Vec3> out(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) out[i] = normals[of_point[i]];
    return out;
}

}  // namespace surflux
