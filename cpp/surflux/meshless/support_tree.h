#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/span.h"
#include "surflux/core/vec.h"
#include "surflux/meshless/basis_weight.h"

namespace surflux {

// The weight functions of one object on one level (L07 eqs. 12 and 13), found by place: L07 has an R-tree, this is a
// tree of boxes around supports, eight to a node and eight functions to a leaf, so that a node or a leaf is one short
// loop over columns of floats. Boxes are relative to the middle of the object and rounded outwards, leaves relative to
// their own middle: coordinates of 5e6 m cost no digits of a weight.
// Hashed cells with a list of the functions that reach each were .65 to 1.5 times as fast up to 10 000 functions, and 1
// to 2.6 times for 600 000, for ten times the memory (770 bytes a function) and only where radii are about equal.
class SupportTree {
public:
    SupportTree(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals, const std::vector<double>& radii,
                Span<std::uint32_t> members);

    // Replaces `out` by all weights w_j(point) > 0, and returns their sum.
    double weights(const Vec3& point, const Vec3& normal, std::vector<BasisWeight>& out) const;
    // The nearest function's point that faces a compatible way, n . n_j > 0, else the nearest of all.
    std::uint32_t nearest(const Vec3& point, const Vec3& normal) const;

private:
    static constexpr std::size_t width = 8;
    struct alignas(32) Node {
        float low[3][width], high[3][width];
        std::uint32_t child[width];  // a node's index, or a leaf's with leaf_bit
    };
    struct alignas(32) Leaf {
        float x[3][width], n[3][width];
        float inverse_square[width];  // 1 / r_j^2
        float height[width];          // 1, or 0 where there is no support
        std::uint32_t function[width];
        Vec3 origin;
        std::uint32_t count;
    };
    struct Box {
        Vec3 low, high;
    };
    struct Builder;

    Vec3 center_;
    double unit_ = 1.0;   // of the floats, a power of 2: their squares are ordinary numbers in any unit of length
    double slack_ = 0.0;  // how much a place moves at most when it is rounded to float
    std::uint32_t root_ = 0;
    std::vector<Node> nodes_;
    std::vector<Leaf> leaves_;
};

}  // namespace surflux
