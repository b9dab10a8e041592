#include "surflux/meshless/multilevel_basis.h"

#include <algorithm>
#include <limits>

#include "surflux/core/error.h"

namespace surflux {

namespace {

// By what functions of a level that corrects a coarser one are less than a partition of unity where they hardly reach:
// a function that is alone at its rim would end in a step, of its whole coefficient (L07 has points on all of each
// level and steps nowhere; ours are only where they are wanted). Within a level weights sum up to 2 or more.
double at_rim(double sum) { return sum >= 1.0 ? 1.0 : sum * sum * (3.0 - 2.0 * sum); }

}  // namespace

void MultilevelBasis::add_level(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                                const std::vector<std::uint32_t>& objects, const SupportOptions& options) {
    require(positions.size() < std::numeric_limits<std::uint32_t>::max() - positions_.size(), "positions: there are ",
            positions.size(), " besides ", positions_.size(), " on coarser levels, wanted fewer than 2^32 in all");
    levels_.emplace_back(positions, normals, objects, options);
    positions_.insert(positions_.end(), positions.begin(), positions.end());
    normals_.insert(normals_.end(), normals.begin(), normals.end());
    objects_.insert(objects_.end(), objects.begin(), objects.end());
    first_.push_back(static_cast<std::uint32_t>(positions_.size()));
}

void MultilevelBasis::set_cuts(std::vector<SupportCut> cuts) {
    for (SupportCut& cut : cuts) cut.function -= first_[levels() - 1];
    levels_.back().set_cuts(std::move(cuts));
}

std::size_t MultilevelBasis::level_of(std::uint32_t function) const {
    return static_cast<std::size_t>(std::upper_bound(first_.begin(), first_.end(), function) - first_.begin()) - 1;
}

bool MultilevelBasis::is_coarsest(std::size_t level, std::uint32_t object) const {
    for (std::size_t above = 0; above < level; ++above)
        if (levels_[above].has(object)) return false;
    return levels_[level].has(object);
}

void MultilevelBasis::weights(std::size_t level, const Vec3& point, const Vec3& normal, std::uint32_t object,
                              std::vector<BasisWeight>& out) const {
    levels_[level].weights(point, normal, object, out);
    if (out.empty() && is_coarsest(level, object)) levels_[level].at_or_nearest(point, normal, object, out);
    for (BasisWeight& w : out) w.function += first_[level];
}

void MultilevelBasis::to_shares(std::size_t level, std::uint32_t object, std::vector<BasisWeight>& weights) const {
    double sum = 0.0;
    for (const BasisWeight& w : weights) sum += w.weight;
    const double fade = sum >= 1.0 || is_coarsest(level, object) ? 1.0 : at_rim(sum);
    for (BasisWeight& w : weights) w.weight *= fade / sum;
}

void MultilevelBasis::at_level(std::size_t level, const Vec3& point, const Vec3& normal, std::uint32_t object,
                               std::vector<BasisWeight>& out) const {
    weights(level, point, normal, object, out);
    to_shares(level, object, out);
}

}  // namespace surflux
