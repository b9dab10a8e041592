#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/span.h"
#include "surflux/core/vec.h"
#include "surflux/meshless/basis_weight.h"
#include "surflux/meshless/support_radii.h"
#include "surflux/meshless/support_tree.h"

namespace surflux {

// A plane beyond which a support does not go on: dot(normal, p) < offset.
struct SupportCut {
    std::uint32_t function;
    Vec3 normal;
    double offset;
};

// One level of L07's basis (sec. 4.1, 4.2): Shepard's functions B_j(p) = w_j(p) / sum_k w_k(p) of points on surfaces,
// w_j(p) = K(|x - x_j| / r_j) max(0, n . n_j)^4, K(t) = 2 t^3 - 3 t^2 + 1 up to t = 1. L07 eq. 12
// has the cosine without a power: on tiles and folds, where points of many directions are close together, it blends
// what has little to do with each other (Sponza: a third off the error). Functions of an object are zero on others.
// Queries are const and may run on many threads at once.
class ShepardLevel {
public:
    ShepardLevel(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                 const std::vector<std::uint32_t>& objects, const SupportOptions& options = {});

    std::size_t size() const { return radii_.size(); }
    double radius(std::uint32_t function) const { return radii_[function]; }
    bool has(std::uint32_t object) const { return tree_of(object) != nullptr; }

    // Ends supports at walls: each has its own cuts, as wall_cuts.h finds them. What lies beyond has no weight.
    void set_cuts(std::vector<SupportCut> cuts);
    Span<SupportCut> cuts(std::uint32_t function) const {
        if (cuts_.empty()) return {nullptr, nullptr};
        return {cuts_.data() + first_cut_[function], cuts_.data() + first_cut_[function + 1]};
    }

    // Replaces `out` by the weights w_j > 0 at a point of an object, of which B_j are the shares. Returns their sum.
    double weights(const Vec3& point, const Vec3& normal, std::uint32_t object, std::vector<BasisWeight>& out) const;
    // Replaces `out` by all functions that are not zero at a point of an object. They are positive and sum to 1; where
    // nothing covers the point there are none. `normal` is of unit length. Returns what the weights summed up to
    // before.
    double at(const Vec3& point, const Vec3& normal, std::uint32_t object, std::vector<BasisWeight>& out) const;
    // The same, but where nothing covers the point the function whose point is nearest speaks alone: of those that face
    // a compatible way, n . n_j > 0, else of all of the object. Empty only where the object has none.
    void at_or_nearest(const Vec3& point, const Vec3& normal, std::uint32_t object,
                       std::vector<BasisWeight>& out) const;

private:
    const SupportTree* tree_of(std::uint32_t object) const;

    bool is_beyond_wall(std::uint32_t function, const Vec3& point) const;

    std::vector<double> radii_;
    std::vector<SupportCut> cuts_;          // by function
    std::vector<std::uint32_t> first_cut_;  // of each function, and the end; none where there are no cuts
    std::vector<std::uint32_t> objects_;    // ascending
    std::vector<SupportTree> trees_;
};

}  // namespace surflux
