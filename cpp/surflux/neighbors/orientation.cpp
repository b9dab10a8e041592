#include "surflux/neighbors/orientation.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/neighbors/signed_forest.h"

namespace surflux {

namespace {

constexpr double upright = 0.3;  // cosine of normals at creases of about 90 degrees, at most

struct Edge {
    float weight;
    bool opposite;  // one of the two normals has to be turned
    std::uint32_t a, b;
    bool operator<(const Edge& other) const {
        if (weight != other.weight) return weight < other.weight;
        return a != other.a ? a < other.a : b < other.b;
    }
};

// In pieces that are merged, with a report after each: of millions of edges one sort takes seconds.
void sort_edges(std::vector<Edge>& edges, const Progress& progress) {
    const auto at = [&](std::size_t k) {
        return edges.begin() + static_cast<std::ptrdiff_t>(std::min(k, edges.size()));
    };
    std::size_t sorted = std::size_t{1} << 16;
    parallel_blocks(
        edges.size(), sorted, [&](std::size_t begin, std::size_t end) { std::sort(at(begin), at(end)); }, progress);
    for (; sorted < edges.size(); sorted *= 2) {
        parallel_blocks(
            edges.size(), 2 * sorted,
            [&](std::size_t begin, std::size_t end) { std::inplace_merge(at(begin), at(begin + sorted), at(end)); },
            progress);
    }
}

double median(std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double outwardness(const std::vector<Vec3>& places, const std::vector<double>& spacing,
                   const std::vector<std::uint32_t>& members, const std::vector<Vec3>& normals) {
    // Not the mean, not the vectors themselves, no area without a limit: one outlier would outweigh all the others.
    Vec3 center;
    std::vector<double> values(members.size());
    for (int axis = 0; axis < 3; ++axis) {
        for (std::size_t k = 0; k < members.size(); ++k) values[k] = places[members[k]][axis];
        center[axis] = median(values);
    }
    for (std::size_t k = 0; k < members.size(); ++k) values[k] = spacing[members[k]];
    const double largest = 4.0 * median(values);
    double sum = 0.0;
    for (std::uint32_t i : members) {
        const Vec3 d = places[i] - center;
        const double side = std::min(spacing[i], largest);
        if (length_squared(d) > 0.0) sum += side * side * dot(normalized(d), normals[i]);
    }
    return sum;
}

}  // namespace

double agreement(const Vec3& n, const Vec3& m, const Vec3& d) {
    return dot(n, m) - 2.0 * dot(n, d) * dot(m, d) / length_squared(d);
}

bool mirror_decides(double agreement, double cosine) {
    return (agreement < 0.0) != (cosine < 0.0) && std::abs(cosine) > upright;
}

TreeLink::TreeLink(const Vec3& n, const Vec3& m, const Vec3& d, double spacings)
    : agree(agreement(n, m, d)),
      weight(1.0 - std::abs(agree) + 0.1 * length(d) / spacings),
      is_doubtful(mirror_decides(agree, dot(n, m))) {}

std::vector<std::uint32_t> orient_sheets(const std::vector<Vec3>& places, const std::vector<double>& spacing,
                                         const NeighborGraph& graph, double least, std::vector<Vec3>& normals,
                                         const Progress& progress) {
    std::vector<std::size_t> start(places.size() + 1, 0);
    for (std::size_t i = 0; i < places.size(); ++i) start[i + 1] = start[i] + graph[i].size();
    std::vector<Edge> edges(start.back());
    parallel_for(places.size(), 1024, [&](std::size_t i) {
        for (std::size_t k = 0; k < graph[i].size(); ++k) {
            const auto from = static_cast<std::uint32_t>(i);
            const std::uint32_t to = graph[i][k];
            const TreeLink link(normals[i], normals[to], places[to] - places[i], spacing[i] + spacing[to]);
            // Smaller index first, so that an edge seen from both its ends is the same edge.
            Edge& edge = edges[start[i] + k];
            edge = {static_cast<float>(link.weight), link.agree < 0.0, std::min(from, to), std::max(from, to)};
            if (least > 0.0 && (link.is_doubtful || std::abs(link.agree) < least)) edge.a = edge.b;  // leads nowhere
        }
    });
    sort_edges(edges, progress);
    SignedForest forest(places.size());
    for (std::size_t k = 0; k < edges.size(); ++k) {
        forest.join(edges[k].a, edges[k].b, edges[k].opposite);
        report_some(progress, k, edges.size(), std::size_t{1} << 18);
    }

    std::vector<std::uint32_t> roots(places.size());
    parallel_for(places.size(), 1024, [&](std::size_t i) {
        bool turned;
        roots[i] = forest.root(static_cast<std::uint32_t>(i), turned);
        if (turned) normals[i] = -normals[i];
    });
    return roots;
}

void orient_consistently(const std::vector<Vec3>& places, const std::vector<double>& spacing,
                         const NeighborGraph& graph, std::vector<Vec3>& normals, const Progress& progress) {
    const auto roots = orient_sheets(places, spacing, graph, 0.0, normals, progress);
    for (const std::vector<std::uint32_t>& members : groups_of(roots))
        if (outwardness(places, spacing, members, normals) < 0.0)
            for (std::uint32_t i : members) normals[i] = -normals[i];
}

std::vector<std::vector<std::uint32_t>> groups_of(const std::vector<std::uint32_t>& numbers) {
    constexpr std::uint32_t none = 0xffffffffu;
    std::vector<std::uint32_t> group(numbers.size(), none);  // of each number, all of which are indices
    std::vector<std::vector<std::uint32_t>> out;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        std::uint32_t& g = group[numbers[i]];
        if (g == none) {
            g = static_cast<std::uint32_t>(out.size());
            out.emplace_back();
        }
        out[g].push_back(static_cast<std::uint32_t>(i));
    }
    return out;
}

}  // namespace surflux
