#include "surflux/scene/box_tree.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr std::size_t leaf_size = 4;
constexpr int no_size = -2000;  // below the exponent of any number

Box around(const Box& a, const Box& b) {
    Box out = a;
    for (int axis = 0; axis < 3; ++axis) {
        out.low[axis] = std::min(a.low[axis], b.low[axis]);
        out.high[axis] = std::max(a.high[axis], b.high[axis]);
    }
    return out;
}

int size_of(const Box& box) {
    const double diagonal = length(box.high - box.low);
    return diagonal > 0.0 ? std::ilogb(diagonal) / 2 : no_size;
}

}  // namespace

BoxTree::BoxTree(const std::vector<Box>& boxes) {
    std::vector<Vec3> centers(boxes.size());
    std::vector<int> size(boxes.size());
    parallel_for(boxes.size(), 4096, [&](std::size_t k) {
        centers[k] = 0.5 * (boxes[k].low + boxes[k].high);
        size[k] = size_of(boxes[k]);
    });
    index_ = morton_order(centers);
    std::stable_sort(index_.begin(), index_.end(), [&](std::uint32_t a, std::uint32_t b) { return size[a] < size[b]; });
    boxes_.resize(boxes.size());
    for (std::size_t e = 0; e < index_.size(); ++e) boxes_[e] = boxes[index_[e]];
    for (std::size_t begin = 0, end; begin < index_.size(); begin = end) {
        for (end = begin; end < index_.size() && size[index_[end]] == size[index_[begin]]; ++end) continue;
        Tree tree{begin, end, nodes_.size(), 0};
        while (((end - begin) >> tree.depth) > leaf_size) ++tree.depth;
        nodes_.resize(nodes_.size() + (std::size_t{2} << tree.depth) - 1);
        for (int d = tree.depth; d >= 0; --d)
            parallel_for(std::size_t{1} << d, 1024, [&](std::size_t k) {
                Box& node = nodes_[tree.node(d, k)];
                if (d < tree.depth) {
                    node = around(nodes_[tree.node(d + 1, 2 * k)], nodes_[tree.node(d + 1, 2 * k + 1)]);
                    return;
                }
                node = boxes_[tree.start(d, k)];
                for (std::size_t e = tree.start(d, k) + 1; e < tree.start(d, k + 1); ++e)
                    node = around(node, boxes_[e]);
            });
        trees_.push_back(tree);
    }
}

}  // namespace surflux
