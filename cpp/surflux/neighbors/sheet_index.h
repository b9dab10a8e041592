#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

// A kd-tree over positions and unit normals, searched by distance and angle at once. Each place is found once: later
// searches pass over it. Splits go through space and through the sphere of normals, whichever is wider against what
// searches reach, so that searches cost about what they find: in a pile, or where each reaches everything, too.
class SheetIndex {
public:
    // reach: how far the search from each place will go. Places of different `group` never find each other.
    SheetIndex(const std::vector<Vec3>& places, const std::vector<Vec3>& normals, const std::vector<double>& reach,
               const std::vector<std::uint32_t>& group, double epsilon, const Progress& progress = {});

    // Appends to `out` place i and every j of its group with |x_i - x_j| < reach_i and n_i . n_j > epsilon, those
    // taken before left out, in an order that depends on the places alone; where `joined` is given, only those that it
    // says yes to.
    using Joined = std::function<bool(std::uint32_t i, std::uint32_t j)>;
    void take(std::uint32_t i, std::vector<std::uint32_t>& out, const Joined& joined = nullptr);
    bool is_taken(std::uint32_t i) const { return taken_[slot_[i]] != 0; }
    // Neighbours have ranks that are close, mostly.
    std::uint32_t rank(std::uint32_t i) const { return slot_[i]; }

private:
    struct Entry {
        Vec3 place, normal;
        double reach;
        std::uint32_t index;
    };
    struct Node {
        Vec3 low, high;                // of the places
        Vec3 normal_low, normal_high;  // of the normals
        std::uint32_t remaining = 0;   // at least as many as are not taken yet
    };
    // A balanced tree over the entries [begin, end): node k of depth d, at nodes_[root + 2^d - 1 + k], holds those
    // from begin + count k / 2^d on.
    struct Tree {
        std::size_t begin, end, root;
        int depth;
        std::size_t start(int d, std::size_t k) const { return begin + (((end - begin) * k) >> d); }
    };

    void build(const Tree& tree, const Progress& progress);
    void split(Node& node, std::size_t begin, std::size_t middle, std::size_t end);
    std::uint32_t search(const Tree& tree, int depth, std::size_t k, const Entry& from, std::vector<std::uint32_t>& out,
                         const Joined& joined);

    double epsilon_;
    std::vector<Entry> entries_;
    std::vector<std::uint32_t> slot_;     // of each place among the entries
    std::vector<std::uint32_t> tree_of_;  // of each place
    std::vector<std::uint8_t> taken_;     // by slot
    std::vector<Tree> trees_;
    std::vector<Node> nodes_;
};

}  // namespace surflux
