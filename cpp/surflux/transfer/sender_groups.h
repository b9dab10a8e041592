#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/lights/sample_points.h"
#include "surflux/scene/scene.h"
#include "surflux/transfer/sparse_rows.h"

namespace surflux {

// The senders of a transport operator: groups of neighbouring surfels that face about alike, halved until there are as
// many as wanted, and the groups that were halved on the way, a binary tree. Each node sends the mean of what its
// surfels send by area, so light has to be known in the leaves alone: so many places, however many surfels there are.
class SenderGroups {
public:
    static constexpr std::uint32_t none = 0xffffffffu;

    struct Node {
        std::uint32_t parent = none, child = none;  // the first of two, which are neighbours; none of a leaf
        float area = 0.0f;
        float radius = 0.0f;  // of a sphere around the mean position, around all of its surfels
        // Length of the mean of their normals; 0 where light of some is hidden from others, `walled` where a wall has
        // some of them on one side and some on the other.
        float alike = 0.0f;
        float weight = 0.0f;  // times what its surfels are unlike
        static constexpr float walled = -1.0f;
        bool is_leaf() const { return child == none; }
        bool is_walled() const { return alike == walled; }
    };

    SenderGroups() = default;
    // How unlike the surfels of a group are lit, from a number for the random numbers that it takes.
    struct Lit {
        // The mean of |a - b| / (a + b) over pairs: 0 where they are lit alike, 1 where one alone is.
        float unlike = 0.0f;
        bool parted = false;  // is light of some hidden from others?
    };
    using Unlikeness = std::function<Lit(const std::uint32_t* surfels, std::size_t count, std::uint64_t stream)>;
    struct Sides {
        bool are_two = false;  // with a wall between them
        std::vector<char> of;  // 0 and 1, the side of each surfel; empty where that is not known
        bool are_sure = true;  // or are halves to be asked again?
    };
    // What is asked about walls; nothing where a function is empty.
    struct Walls {
        // Does one part the two halves of a group, of which the second begins at `middle`?
        std::function<bool(const std::uint32_t* surfels, std::size_t middle, std::size_t count, std::uint64_t stream)>
            halves;
        // Does one go through a group?
        std::function<Sides(const std::uint32_t* surfels, std::size_t count, std::uint64_t stream)> sides;
    };
    // `areas`: what of each surfel sends and receives; others are in groups, too, for rays that meet them. `weight`:
    // how much light is to be expected there, by area: the groups are halved first for which, times `unlikeness`, it is
    // most. Groups that a wall goes through are parted there, as far as so many leaves do.
    SenderGroups(const Scene& scene, const std::vector<double>& areas, const std::vector<double>& weight,
                 std::size_t leaves, const Unlikeness& unlikeness, const Walls& walls, const Progress& progress);

    std::size_t size() const { return nodes.size(); }
    // What sends for a surfel that is met: the largest group around it that a circle of radius `reach` covers, or the
    // leaf.
    std::uint32_t sender(std::uint32_t surfel, double reach) const;

    // Means over the leaves by area, `colors` for each node: 0 for all others.
    template <class Values>
    std::vector<float> means(const Values& of_surfel, const std::vector<double>& areas) const {
        std::vector<Rgb> sum(size());
        std::vector<double> area(size(), 0.0);
        for (std::size_t i = 0; i < areas.size(); ++i) {
            sum[leaf_of_surfel[i]] += areas[i] * of_surfel[i];
            area[leaf_of_surfel[i]] += areas[i];
        }
        std::vector<float> out(colors * size(), 0.0f);
        for (const std::uint32_t leaf : leaves)
            for (int c = 0; c < 3 && area[leaf] > 0.0; ++c)
                out[colors * leaf + static_cast<std::size_t>(c)] = static_cast<float>(sum[leaf][c] / area[leaf]);
        return out;
    }

    // Fills in what all nodes send from what leaves do: `channels` interleaved values each.
    void pull_up(std::vector<float>& values, std::size_t channels) const;

    struct Range {
        std::size_t first, last;
    };

    std::vector<Node> nodes;  // children behind their parents, what is near each other mostly near each other
    std::vector<std::uint32_t> leaf_of_surfel;
    std::vector<std::uint32_t> leaves;  // nodes that are, in the order of the tree: neighbours near each other

private:
    class Growth;  // of the tree
    // Numbers the nodes anew, with the surfels that are theirs.
    void number_by_place(std::vector<Range>& ranges);
};

// The surfels of each leaf, by its number in SenderGroups::leaves.
struct SurfelsOfLeaves {
    explicit SurfelsOfLeaves(const SenderGroups& groups);
    template <class Visit>
    void for_leaf(std::size_t leaf, const Visit& visit) const {
        for (std::uint32_t k = first[leaf]; k < first[leaf + 1]; ++k) visit(surfels[k]);
    }
    std::vector<std::uint32_t> number;          // of each node that is a leaf
    std::vector<std::uint32_t> first, surfels;  // of each leaf, and the end
};

// Places at which light is asked for, `of_leaf` for each leaf, in the order of SenderGroups::leaves: drawn by area, one
// from each of so many parts of it.
struct SenderSamples {
    struct Sample {
        float x, y, z;  // from the origin
        float normal_x, normal_y, normal_z;
        std::uint32_t surfel;
    };
    Vec3 position(std::size_t k) const {
        const Sample& of = samples[k];
        return origin[0] + Vec3{static_cast<double>(of.x), static_cast<double>(of.y), static_cast<double>(of.z)};
    }
    Vec3 normal(std::size_t k) const {
        const Sample& of = samples[k];
        return {static_cast<double>(of.normal_x), static_cast<double>(of.normal_y), static_cast<double>(of.normal_z)};
    }

    std::size_t of_leaf = 0;
    std::vector<Vec3> origin{Vec3()};  // one
    std::vector<Sample> samples;
};

SenderSamples sample_senders(const Scene& scene, const SurfelPoints& points, const std::vector<double>& areas,
                             const SenderGroups& groups, std::size_t of_leaf, std::uint64_t seed);

}  // namespace surflux
