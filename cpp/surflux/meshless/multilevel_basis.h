#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/meshless/basis_weight.h"
#include "surflux/meshless/shepard_level.h"

namespace surflux {

// L07's hierarchical basis (sec. 4.1): levels of ever denser points on surfaces; each level's Shepard functions
// approximate the residual of the coarser levels. Functions are numbered through, coarse levels first. Queries are
// const and may run on many threads at once.
class MultilevelBasis {
public:
    static constexpr std::size_t all_levels = static_cast<std::size_t>(-1);

    // The next finer level; its points are those that coarser levels do not have.
    void add_level(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                   const std::vector<std::uint32_t>& objects, const SupportOptions& options = {});

    // Of the finest level; functions are numbered as in the basis.
    void set_cuts(std::vector<SupportCut> cuts);
    // The planes that end a function's support, two at most.
    Span<SupportCut> cuts(std::uint32_t function) const {
        const std::size_t level = level_of(function);
        return levels_[level].cuts(function - first_[level]);
    }

    std::size_t levels() const { return levels_.size(); }
    std::size_t size() const { return positions_.size(); }
    // The functions of a level are those from first(level) up to first(level + 1).
    std::uint32_t first(std::size_t level) const { return first_[level]; }
    std::size_t level_of(std::uint32_t function) const;
    const Vec3& position(std::uint32_t function) const { return positions_[function]; }
    const Vec3& normal(std::uint32_t function) const { return normals_[function]; }
    std::uint32_t object(std::uint32_t function) const { return objects_[function]; }
    double radius(std::uint32_t function) const { return radius(level_of(function), function); }
    double radius(std::size_t level, std::uint32_t function) const {
        return levels_[level].radius(function - first_[level]);
    }

    // Replaces `out` by the functions of one level that are not zero at a point: positive, of sum 1, or less at the rim
    // of a finer level, where its weights come to less than 1 before they are made to: there it fades out. Where none
    // is, there are none, but on the coarsest level that the object has: there the nearest that faces a compatible way
    // speaks alone (ShepardLevel::at_or_nearest). At the place of a function on a coarser level these are its children,
    // on a finer level its parents (L07 6.3).
    void at_level(std::size_t level, const Vec3& point, const Vec3& normal, std::uint32_t object,
                  std::vector<BasisWeight>& out) const;
    // The same in two halves, for what chooses among functions in between: their weights w_j, and the shares of them.
    void weights(std::size_t level, const Vec3& point, const Vec3& normal, std::uint32_t object,
                 std::vector<BasisWeight>& out) const;
    void to_shares(std::size_t level, std::uint32_t object, std::vector<BasisWeight>& weights) const;
    // Has the object functions on a level, and on no coarser one?
    bool is_coarsest(std::size_t level, std::uint32_t object) const;

    // Calls visit(function and weight) for all that at_level() gives on levels before `end`.
    template <class Visit>
    void for_functions(const Vec3& point, const Vec3& normal, std::uint32_t object, const Visit& visit,
                       std::size_t end = all_levels) const {
        thread_local std::vector<BasisWeight> weights;
        for (std::size_t level = 0; level < levels() && level < end; ++level) {
            at_level(level, point, normal, object, weights);
            for (const BasisWeight& w : weights) visit(w);
        }
    }

private:
    std::vector<ShepardLevel> levels_;
    std::vector<std::uint32_t> first_{0};
    std::vector<Vec3> positions_, normals_;
    std::vector<std::uint32_t> objects_;
};

}  // namespace surflux
