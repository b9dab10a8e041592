#pragma once

#include <cstdint>
#include <vector>

#include "surflux/scene/surfels.h"

namespace surflux {

// A bounding volume hierarchy over boxes: for each power of four of their diagonals a balanced tree along the Morton
// curve, so that a few large boxes do not make the nodes of many small ones large.
class BoxTree {
public:
    explicit BoxTree(const std::vector<Box>& boxes);

    // Calls found(k) for boxes that meets(box) says yes to. It must say yes to all boxes around one that it meets.
    template <class Meets, class Found>
    void visit(const Meets& meets, const Found& found) const {
        for (const Tree& tree : trees_) visit(tree, 0, 0, meets, found);
    }

private:
    // Node k of depth d, at nodes_[root + 2^d - 1 + k], is around the entries from begin + count k / 2^d on.
    struct Tree {
        std::size_t begin, end, root;
        int depth;
        std::size_t node(int d, std::size_t k) const { return root + (std::size_t{1} << d) - 1 + k; }
        std::size_t start(int d, std::size_t k) const { return begin + (((end - begin) * k) >> d); }
    };

    template <class Meets, class Found>
    void visit(const Tree& tree, int depth, std::size_t k, const Meets& meets, const Found& found) const {
        if (!meets(nodes_[tree.node(depth, k)])) return;
        if (depth < tree.depth) {
            visit(tree, depth + 1, 2 * k, meets, found);
            visit(tree, depth + 1, 2 * k + 1, meets, found);
            return;
        }
        for (std::size_t e = tree.start(depth, k); e < tree.start(depth, k + 1); ++e)
            if (meets(boxes_[e])) found(index_[e]);
    }

    std::vector<Box> boxes_;  // in the order of the trees
    std::vector<std::uint32_t> index_;
    std::vector<Box> nodes_;
    std::vector<Tree> trees_;
};

}  // namespace surflux
