#include "surflux/transfer/sender_groups.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>

#include "surflux/core/bisection.h"
#include "surflux/core/parallel.h"
#include "surflux/core/random.h"

namespace surflux {

namespace {

constexpr double least_alike = 0.8;  // of a group that sends as one: what it hides of itself is darker than what of it
                                     // is seen (as D04 eq. 10 has it)
constexpr double normal_weight = 1.5;  // as Bisection has it: the two sides of a sheet part first

constexpr float mixed = 8.0f;  // how much sooner groups are halved that face all ways

struct Range {
    std::size_t first, last;
};

SenderGroups::Node describe(const Surfels& s, const std::vector<double>& areas, const std::vector<double>& weights,
                            const std::vector<std::uint32_t>& order, Range range) {
    double area = 0.0, weight = 0.0;
    Vec3 middle, normal, plain;
    for (std::size_t k = range.first; k < range.last; ++k) {
        const std::uint32_t i = order[k];
        area += areas[i];
        weight += areas[i] * weights[i];
        middle += areas[i] * s.positions[i];
        normal += areas[i] * s.normals[i];
        plain += s.positions[i];
    }
    middle = area > 0.0 ? middle / area : plain / static_cast<double>(range.last - range.first);
    SenderGroups::Node node;
    node.area = static_cast<float>(area);
    node.weight = static_cast<float>(weight);
    node.alike = area > 0.0 ? static_cast<float>(length(normal) / area) : 0.0f;
    double radius = 0.0;
    for (std::size_t k = range.first; k < range.last; ++k)
        radius = std::max(radius, length(s.positions[order[k]] - middle) + s.radii[order[k]]);
    node.radius = static_cast<float>(radius);
    return node;
}

}  // namespace

SenderGroups::SenderGroups(const Scene& scene, const std::vector<double>& areas, const std::vector<double>& weight,
                           std::size_t most, const Progress& progress) {
    const Surfels& s = scene.surfels;
    Bisection halving(s.size(), normal_weight);
    const auto place = [&](std::uint32_t i) { return PlaceAndNormal{s.positions[i], s.normals[i]}; };
    const auto describe_range = [&](Range range) { return describe(s, areas, weight, halving.order, range); };
    std::vector<Range> ranges{{0, scene.surfels.size()}};
    nodes.push_back(describe_range(ranges[0]));
    // What sends the most in the most different ways is halved first.
    const auto less = [&](std::uint32_t a, std::uint32_t b) {
        const auto spread = [&](std::uint32_t k) { return nodes[k].weight * (1.0f + mixed * (1.0f - nodes[k].alike)); };
        return spread(a) < spread(b) || (spread(a) == spread(b) && a > b);
    };
    std::priority_queue<std::uint32_t, std::vector<std::uint32_t>, decltype(less)> open(less);
    open.push(0);
    std::size_t count = 1;
    while (count < most && !open.empty()) {
        report_some(progress, count, most, 64);
        const std::uint32_t node = open.top();
        open.pop();
        const Range range = ranges[node];
        if (range.last - range.first < 2) continue;
        const std::size_t middle = halving.halve(range.first, range.last, place);
        nodes[node].child = static_cast<std::uint32_t>(nodes.size());
        for (const Range half : {Range{range.first, middle}, Range{middle, range.last}}) {
            ranges.push_back(half);
            nodes.push_back(describe_range(half));
            nodes.back().parent = node;
            open.push(static_cast<std::uint32_t>(nodes.size() - 1));
        }
        ++count;
    }
    leaf_of_surfel.resize(scene.surfels.size());
    for (std::uint32_t k = 0; k < nodes.size(); ++k)
        if (nodes[k].is_leaf()) {
            leaves.push_back(k);
            for (std::size_t i = ranges[k].first; i < ranges[k].last; ++i) leaf_of_surfel[halving.order[i]] = k;
        }
    std::sort(leaves.begin(), leaves.end(),
              [&](std::uint32_t a, std::uint32_t b) { return ranges[a].first < ranges[b].first; });
}

std::uint32_t SenderGroups::sender(std::uint32_t surfel, double reach) const {
    std::uint32_t at = leaf_of_surfel[surfel];
    for (std::uint32_t up = nodes[at].parent; up != none; up = nodes[at].parent) {
        if (static_cast<double>(nodes[up].radius) > reach || static_cast<double>(nodes[up].alike) < least_alike) break;
        at = up;
    }
    return at;
}

void SenderGroups::pull_up(std::vector<float>& values, std::size_t channels) const {
    for (std::size_t k = nodes.size(); k-- > 0;) {
        if (nodes[k].is_leaf()) continue;
        const std::size_t child = nodes[k].child;
        const float area = nodes[k].area;
        const float share = area > 0.0f ? nodes[child].area / area : 0.5f;
        for (std::size_t c = 0; c < channels; ++c)
            values[k * channels + c] =
                share * values[child * channels + c] + (1.0f - share) * values[(child + 1) * channels + c];
    }
}

SenderSamples sample_senders(const Scene& scene, const SurfelPoints& points, const std::vector<double>& areas,
                             const SenderGroups& groups, std::size_t of_leaf, std::uint64_t seed) {
    const Surfels& s = scene.surfels;
    // Surfels by leaf.
    std::vector<std::uint32_t> number(groups.size(), 0);
    for (std::uint32_t k = 0; k < groups.leaves.size(); ++k) number[groups.leaves[k]] = k;
    std::vector<std::uint32_t> first(groups.leaves.size() + 1, 0), members(s.size());
    for (const std::uint32_t leaf : groups.leaf_of_surfel) ++first[number[leaf] + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t i = 0; i < s.size(); ++i) members[next[number[groups.leaf_of_surfel[i]]]++] = i;
    SenderSamples out;
    out.of_leaf = of_leaf;
    out.positions.resize(groups.leaves.size() * of_leaf);
    out.surfels.resize(out.positions.size());
    parallel_for(groups.leaves.size(), 256, [&](std::size_t k) {
        Random random(seed, k);
        double all = 0.0;
        for (std::size_t m = first[k]; m < first[k + 1]; ++m) all += areas[members[m]];
        std::size_t m = first[k];
        double up_to = areas[members[m]];
        for (std::size_t p = 0; p < of_leaf; ++p) {
            const double at = (static_cast<double>(p) + random.uniform()) / static_cast<double>(of_leaf) * all;
            while (up_to <= at && m + 1 < first[k + 1]) up_to += areas[members[++m]];
            const std::uint32_t i = members[m];
            const double u = random.uniform(), v = random.uniform();
            out.positions[k * of_leaf + p] = points.extends(i) ? points.at(i, u, v) : s.positions[i];
            out.surfels[k * of_leaf + p] = i;
        }
    });
    return out;
}

}  // namespace surflux
