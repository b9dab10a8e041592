#include "surflux/neighbors/sheet_index.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "surflux/core/parallel.h"
#include "surflux/core/resize.h"

namespace surflux {

namespace {

constexpr std::size_t leaf_size = 8;

void widen(Vec3& low, Vec3& high, const Vec3& p) {
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
    }
}

int widest(const Vec3& span) { return span.x >= span.y && span.x >= span.z ? 0 : span.y >= span.z ? 1 : 2; }

}  // namespace

SheetIndex::SheetIndex(const std::vector<Vec3>& places, const std::vector<Vec3>& normals,
                       const std::vector<double>& reach, const std::vector<std::uint32_t>& group, double epsilon,
                       const Progress& progress)
    : epsilon_(epsilon), slot_(places.size()), tree_of_(places.size()), taken_(places.size()) {
    resize_with_reports(entries_, places.size(), progress);
    std::vector<std::uint32_t> order(places.size());
    std::iota(order.begin(), order.end(), 0u);
    if (!std::is_sorted(group.begin(), group.end()))
        std::stable_sort(order.begin(), order.end(),
                         [&](std::uint32_t a, std::uint32_t b) { return group[a] < group[b]; });
    parallel_for(
        order.size(), 4096,
        [&](std::size_t s) { entries_[s] = {places[order[s]], normals[order[s]], reach[order[s]], order[s]}; },
        progress);
    std::size_t nodes = 0;
    for (std::size_t begin = 0, end; begin < order.size(); begin = end) {
        for (end = begin; end < order.size() && group[order[end]] == group[order[begin]]; ++end)
            tree_of_[order[end]] = static_cast<std::uint32_t>(trees_.size());
        Tree tree{begin, end, nodes, 0};
        while (((end - begin) >> tree.depth) > leaf_size) ++tree.depth;
        nodes += (std::size_t{2} << tree.depth) - 1;
        trees_.push_back(tree);
    }
    resize_with_reports(nodes_, nodes, progress);
    for (const Tree& tree : trees_) build(tree, progress);
    for (std::size_t s = 0; s < entries_.size(); ++s) slot_[entries_[s].index] = static_cast<std::uint32_t>(s);
}

void SheetIndex::build(const Tree& tree, const Progress& progress) {
    for (int d = 0; d <= tree.depth; ++d) {
        const std::size_t width = std::size_t{1} << d;
        const std::size_t grain = std::max<std::size_t>(1, (width << 10) / (tree.end - tree.begin));
        const auto split_one = [&](std::size_t k) {
            const std::size_t begin = tree.start(d, k), end = tree.start(d, k + 1);
            const std::size_t middle = d < tree.depth ? tree.start(d + 1, 2 * k + 1) : end;
            split(nodes_[tree.root + width - 1 + k], begin, middle, end);
        };
        parallel_for(width, grain, split_one, progress);
    }
}

void SheetIndex::split(Node& node, std::size_t begin, std::size_t middle, std::size_t end) {
    constexpr double far = std::numeric_limits<double>::infinity();
    node.low = node.normal_low = {far, far, far};
    node.high = node.normal_high = {-far, -far, -far};
    node.remaining = static_cast<std::uint32_t>(end - begin);
    double inverse_reach = 0.0;
    for (std::size_t s = begin; s < end; ++s) {
        widen(node.low, node.high, entries_[s].place);
        widen(node.normal_low, node.normal_high, entries_[s].normal);
        inverse_reach += 1.0 / entries_[s].reach;
    }
    if (middle == end) return;
    // The harmonic mean: a few that reach very far must not keep all others from splits through space.
    const Vec3 span = (inverse_reach / static_cast<double>(end - begin)) * (node.high - node.low);
    const Vec3 turn = (node.normal_high - node.normal_low) / std::sqrt(2.0 - 2.0 * epsilon_);
    const int axis = widest(span), normal_axis = widest(turn);
    const bool in_space = span[axis] >= turn[normal_axis];
    const auto at = [&](std::size_t s) { return entries_.begin() + static_cast<std::ptrdiff_t>(s); };
    std::nth_element(at(begin), at(middle), at(end), [&](const Entry& a, const Entry& b) {
        const double u = in_space ? a.place[axis] : a.normal[normal_axis];
        const double v = in_space ? b.place[axis] : b.normal[normal_axis];
        return u != v ? u < v : a.index < b.index;
    });
}

void SheetIndex::take(std::uint32_t i, std::vector<std::uint32_t>& out, const Joined& joined) {
    const std::uint32_t own = slot_[i];
    if (!taken_[own]) {  // first, and whatever rounding says of n_i . n_i; the counts on its way stay one too high
        taken_[own] = 1;
        out.push_back(i);
    }
    search(trees_[tree_of_[i]], 0, 0, entries_[own], out, joined);
}

std::uint32_t SheetIndex::search(const Tree& tree, int depth, std::size_t k, const Entry& from,
                                 std::vector<std::uint32_t>& out, const Joined& joined) {
    Node& node = nodes_[tree.root + (std::size_t{1} << depth) - 1 + k];
    if (node.remaining == 0) return 0;
    // Rounded sums of terms that are no smaller are no smaller: these bounds hold to the last bit.
    Vec3 gap, most;
    for (int axis = 0; axis < 3; ++axis) {
        gap[axis] = std::max({node.low[axis] - from.place[axis], from.place[axis] - node.high[axis], 0.0});
        most[axis] = from.normal[axis] * (from.normal[axis] > 0.0 ? node.normal_high : node.normal_low)[axis];
    }
    const double reach_squared = from.reach * from.reach;
    if (length_squared(gap) >= reach_squared || most.x + most.y + most.z <= epsilon_) return 0;
    std::uint32_t found = 0;
    if (depth < tree.depth) {
        found = search(tree, depth + 1, 2 * k, from, out, joined);
        found += search(tree, depth + 1, 2 * k + 1, from, out, joined);
    } else {
        for (std::size_t s = tree.start(depth, k); s < tree.start(depth, k + 1); ++s) {
            const Entry& e = entries_[s];
            if (taken_[s] || length_squared(e.place - from.place) >= reach_squared) continue;
            if (dot(from.normal, e.normal) <= epsilon_) continue;
            if (joined && !joined(from.index, e.index)) continue;
            taken_[s] = 1;
            out.push_back(e.index);
            ++found;
        }
    }
    node.remaining -= found;
    return found;
}

}  // namespace surflux
