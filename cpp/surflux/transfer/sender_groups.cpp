#include "surflux/transfer/sender_groups.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "surflux/core/bisection.h"
#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"

namespace surflux {

namespace {

constexpr double least_alike = 0.8;  // of a group that sends as one: what it hides of itself is darker than what of it
                                     // is seen (as D04 eq. 10 has it)
constexpr double normal_weight = 1.5;  // as Bisection has it: the two sides of a sheet part first
constexpr float scattered = 0.2f;      // what the area around a group counts, beside its own
// Of the leaves one in so many is kept for groups that walls go through, when these are looked for.
constexpr std::size_t shares_for_walls[] = {2, 4, 8};

SenderGroups::Node describe(const Surfels& s, const std::vector<double>& areas, const std::vector<double>& weights,
                            const std::vector<std::uint32_t>& order, SenderGroups::Range range) {
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

// By axis: few that are far away do not take floats from all others.
Vec3 median(const std::vector<Vec3>& positions) {
    Vec3 out;
    std::vector<double> at(positions.size());
    for (int axis = 0; axis < 3 && !positions.empty(); ++axis) {
        std::transform(positions.begin(), positions.end(), at.begin(), [&](const Vec3& p) { return p[axis]; });
        const auto middle = at.begin() + static_cast<std::ptrdiff_t>(at.size() / 2);
        std::nth_element(at.begin(), middle, at.end());
        out[axis] = *middle;
    }
    return out;
}

}  // namespace

class SenderGroups::Growth {
public:
    Growth(const Scene& scene, const std::vector<double>& areas, const std::vector<double>& weights, std::size_t most,
           const Unlikeness& unlikeness, const Walls& walls, const Progress& progress)
        : surfels_(scene.surfels),
          areas_(areas),
          weights_(weights),
          most_(most),
          unlikeness_(unlikeness),
          walls_(walls),
          progress_(progress),
          halving(surfels_.size(), normal_weight),
          ranges{{0, surfels_.size()}},
          nodes{describe(surfels_, areas, weights, halving.order, ranges[0])} {
        open_.push_back(0);
    }

    void run() {
        if (walls_.sides && surfels_.size() > most_)
            for (const std::size_t share : shares_for_walls) {
                halve(most_ - most_ / share);
                part_by_walls();
            }
        halve(most_);
        for (std::size_t k = nodes.size(); k-- > 0;) {  // what parts some parts all
            Node& node = nodes[k];
            if (is_walled_[k] != 0) node.alike = Node::walled;
            if (k > 0 && !(node.alike > 0.0f))
                nodes[node.parent].alike = std::min(nodes[node.parent].alike, node.alike);
        }
    }

private:
    const Surfels& surfels_;
    const std::vector<double>&areas_, &weights_;
    const std::size_t most_;
    const Unlikeness& unlikeness_;
    const Walls& walls_;
    const Progress& progress_;
    std::vector<std::uint32_t> open_;               // a heap by weight; some may have children by now
    std::vector<char> is_walled_{0}, is_whole_{0};  // of each node: is there a wall between its children, none in it?
    std::size_t leaves_ = 1;

public:
    Bisection halving;
    std::vector<Range> ranges;
    std::vector<Node> nodes;

private:
    bool is_less(std::uint32_t a, std::uint32_t b) const {
        return nodes[a].weight < nodes[b].weight || (nodes[a].weight == nodes[b].weight && a > b);
    }

    void add_children(std::uint32_t node, std::size_t middle) {
        const Range range = ranges[node];
        nodes[node].child = static_cast<std::uint32_t>(nodes.size());
        nodes.resize(nodes.size() + 2);
        ranges.push_back({range.first, middle});
        ranges.push_back({middle, range.last});
        nodes[nodes.size() - 2].parent = nodes.back().parent = node;
        is_walled_.resize(nodes.size(), 0);
        is_whole_.resize(nodes.size(), is_whole_[node]);
        ++leaves_;
    }

    // All nodes from `before` on, pairs of children.
    void describe_from(std::size_t before) {
        parallel_for(nodes.size() - before, 4, [&](std::size_t k) {
            Node& node = nodes[before + k];
            const Range range = ranges[before + k];
            const std::uint32_t parent = node.parent;
            node = describe(surfels_, areas_, weights_, halving.order, range);
            node.parent = parent;
            // Few surfels that lie scattered are seen from near, each by others.
            const float around = scattered * static_cast<float>(pi) * node.radius * node.radius;
            node.weight *= node.area > 0.0f ? 1.0f + around / node.area : 0.0f;
            const Lit lit = unlikeness_(of(range), range.last - range.first, before + k);
            node.weight *= lit.unlike;
            if (lit.parted) node.alike = 0.0f;
            if (k % 2 == 1 || !walls_.halves) return;
            const Range both = ranges[parent];
            is_walled_[parent] = walls_.halves(of(both), range.last - both.first, both.last - both.first, parent);
        });
        for (std::size_t k = before; k < nodes.size(); ++k) {
            open_.push_back(static_cast<std::uint32_t>(k));
            std::push_heap(open_.begin(), open_.end(), [&](std::uint32_t a, std::uint32_t b) { return is_less(a, b); });
        }
    }
    auto place() const {
        return [this](std::uint32_t i) { return PlaceAndNormal{surfels_.positions[i], surfels_.normals[i]}; };
    }
    const std::uint32_t* of(const Range& range) const { return halving.order.data() + range.first; }

    void halve(std::size_t most) {
        while (leaves_ < most && !open_.empty()) {
            report(progress_, leaves_, most_);
            // Some at a time, whose halves are looked at side by side.
            const std::size_t before = nodes.size(), some = std::min(1 + open_.size() / 8, most - leaves_);
            for (std::size_t k = 0; k < some && !open_.empty(); ++k) {
                std::pop_heap(open_.begin(), open_.end(),
                              [&](std::uint32_t a, std::uint32_t b) { return is_less(a, b); });
                const std::uint32_t node = open_.back();
                open_.pop_back();
                const Range range = ranges[node];
                if (!nodes[node].is_leaf() || range.last - range.first < 2) continue;
                add_children(node, halving.halve(range.first, range.last, place()));
            }
            describe_from(before);
        }
    }

    // Leaves that a wall goes through, those first of which the smaller side has most. Of those that are too large to
    // tell where it is, one half tells later.
    void part_by_walls() {
        struct Parted {
            std::uint32_t node;
            float weight;
            std::vector<char> sides;
        };
        std::vector<std::uint32_t> asked;
        for (std::uint32_t k = 0; k < nodes.size(); ++k)
            if (nodes[k].is_leaf() && is_whole_[k] == 0) asked.push_back(k);
        while (!asked.empty() && leaves_ < most_) {
            report(progress_, leaves_, most_);
            std::vector<Sides> sides(asked.size());
            parallel_for(asked.size(), 4, [&](std::size_t k) {
                const Range range = ranges[asked[k]];
                if (range.last - range.first > 1)
                    sides[k] = walls_.sides(of(range), range.last - range.first, asked[k]);
            });
            std::vector<Parted> found;
            for (std::size_t k = 0; k < asked.size(); ++k) {
                is_whole_[asked[k]] = sides[k].are_sure && !sides[k].are_two;
                if (sides[k].are_two)
                    found.push_back({asked[k], weight_of_smaller(asked[k], sides[k].of), std::move(sides[k].of)});
            }
            std::stable_sort(found.begin(), found.end(),
                             [](const Parted& a, const Parted& b) { return a.weight > b.weight; });
            if (found.size() > most_ - leaves_) found.resize(most_ - leaves_);
            const std::size_t before = nodes.size();
            for (const Parted& parted : found) {
                const Range range = ranges[parted.node];
                add_children(parted.node, parted.sides.empty() ? halving.halve(range.first, range.last, place())
                                                               : part(range, parted.sides));
            }
            describe_from(before);
            asked.resize(nodes.size() - before);
            std::iota(asked.begin(), asked.end(), static_cast<std::uint32_t>(before));
        }
    }

    float weight_of_smaller(std::uint32_t node, const std::vector<char>& sides) const {
        double beyond = 0.0;
        for (std::size_t i = 0; i < sides.size(); ++i)
            if (sides[i] != 0) beyond += areas_[of(ranges[node])[i]];
        const double share = sides.empty() ? 0.5 : beyond / std::max(static_cast<double>(nodes[node].area), 1e-300);
        return nodes[node].weight * static_cast<float>(std::min(share, 1.0 - share));
    }

    // Puts one side first, and returns where the other begins.
    std::size_t part(Range range, const std::vector<char>& sides) {
        std::vector<std::uint32_t> beyond;
        std::size_t middle = range.first;
        for (std::size_t k = range.first; k < range.last; ++k) {
            const std::uint32_t i = halving.order[k];
            if (sides[k - range.first] != 0)
                beyond.push_back(i);
            else
                halving.order[middle++] = i;
        }
        std::copy(beyond.begin(), beyond.end(), halving.order.begin() + static_cast<std::ptrdiff_t>(middle));
        return middle;
    }
};

SenderGroups::SenderGroups(const Scene& scene, const std::vector<double>& areas, const std::vector<double>& weight,
                           std::size_t most, const Unlikeness& unlikeness, const Walls& walls,
                           const Progress& progress) {
    Growth growth(scene, areas, weight, most, unlikeness, walls, progress);
    growth.run();
    nodes = std::move(growth.nodes);
    number_by_place(growth.ranges);
    const std::vector<Range>& ranges = growth.ranges;
    leaf_of_surfel.resize(scene.surfels.size());
    for (std::uint32_t k = 0; k < nodes.size(); ++k)
        if (nodes[k].is_leaf()) {
            leaves.push_back(k);
            for (std::size_t i = ranges[k].first; i < ranges[k].last; ++i) leaf_of_surfel[growth.halving.order[i]] = k;
        }
    std::sort(leaves.begin(), leaves.end(),
              [&](std::uint32_t a, std::uint32_t b) { return ranges[a].first < ranges[b].first; });
}

// Pairs of children are numbered when their parent is met, and each subtree by itself.
void SenderGroups::number_by_place(std::vector<Range>& ranges) {
    std::vector<std::uint32_t> number(nodes.size(), 0), open{0};
    std::uint32_t next = 1;
    while (!open.empty()) {
        const Node& node = nodes[open.back()];
        open.pop_back();
        if (node.is_leaf()) continue;
        number[node.child] = next++;
        number[node.child + 1] = next++;
        open.push_back(node.child + 1);
        open.push_back(node.child);
    }
    std::vector<Node> moved(nodes.size());
    std::vector<Range> moved_ranges(nodes.size());
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        Node node = nodes[k];
        if (node.parent != none) node.parent = number[node.parent];
        if (!node.is_leaf()) node.child = number[node.child];
        moved[number[k]] = node;
        moved_ranges[number[k]] = ranges[k];
    }
    nodes = std::move(moved);
    ranges = std::move(moved_ranges);
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
    // What is below a node is numbered right behind it: blocks of nodes are filled in side by side, but for the few
    // nodes of each that something of a later block is below.
    constexpr std::size_t grain = 4096;
    std::vector<std::vector<std::uint32_t>> late((size() + grain - 1) / grain);
    with_fixed(channels, [&](const auto count) {
        const auto fill_in = [&](std::size_t k) {
            const std::size_t child = nodes[k].child;
            const float area = nodes[k].area, share = area > 0.0f ? nodes[child].area / area : 0.5f;
            auto sum = float_sum(count);
            sum.add(share, values.data() + child * count);
            sum.add(1.0f - share, values.data() + (child + 1) * count);
            sum.write(values.data() + k * count);
        };
        parallel_blocks(size(), grain, [&](std::size_t begin, std::size_t end) {
            std::vector<char> is_late(end - begin, 0);
            for (std::size_t k = end; k-- > begin;) {
                if (nodes[k].is_leaf()) continue;
                const std::size_t child = nodes[k].child;
                if (child + 1 >= end || is_late[child - begin] != 0 || is_late[child + 1 - begin] != 0) {
                    is_late[k - begin] = 1;
                    late[begin / grain].push_back(static_cast<std::uint32_t>(k));
                } else {
                    fill_in(k);
                }
            }
        });
        for (std::size_t block = late.size(); block-- > 0;)
            for (const std::uint32_t k : late[block]) fill_in(k);
    });
}

SurfelsOfLeaves::SurfelsOfLeaves(const SenderGroups& groups)
    : number(groups.size(), 0), first(groups.leaves.size() + 1, 0), surfels(groups.leaf_of_surfel.size()) {
    for (std::uint32_t k = 0; k < groups.leaves.size(); ++k) number[groups.leaves[k]] = k;
    for (const std::uint32_t leaf : groups.leaf_of_surfel) ++first[number[leaf] + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t i = 0; i < surfels.size(); ++i) surfels[next[number[groups.leaf_of_surfel[i]]]++] = i;
}

SenderSamples sample_senders(const Scene& scene, const SurfelPoints& points, const std::vector<double>& areas,
                             const SenderGroups& groups, std::size_t of_leaf, std::uint64_t seed) {
    const Surfels& s = scene.surfels;
    const SurfelsOfLeaves of_leaves(groups);
    const std::vector<std::uint32_t>&first = of_leaves.first, &members = of_leaves.surfels;
    SenderSamples out;
    out.of_leaf = of_leaf;
    std::vector<Vec3> positions(groups.leaves.size() * of_leaf);
    out.samples.resize(groups.leaves.size() * of_leaf);
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
            positions[k * of_leaf + p] = points.extends(i) ? points.at(i, u, v) : s.positions[i];
            out.samples[k * of_leaf + p].surfel = i;
        }
    });
    out.origin[0] = median(positions);
    parallel_for(positions.size(), 4096, [&](std::size_t k) {
        SenderSamples::Sample& sample = out.samples[k];
        const Vec3 p = positions[k] - out.origin[0], &n = s.normals[sample.surfel];
        sample = {static_cast<float>(p.x),
                  static_cast<float>(p.y),
                  static_cast<float>(p.z),
                  static_cast<float>(n.x),
                  static_cast<float>(n.y),
                  static_cast<float>(n.z),
                  sample.surfel};
    });
    return out;
}

}  // namespace surflux
