#pragma once

#include <cstdint>
#include <vector>

#include "surflux/radiosity/surfel_tree.h"

namespace surflux {

struct InsertionOptions {
    double spread = 0.3;       // c of D04 7.2: children stand at (+-c R, +-c R) before they repel each other
    int repulsion_rounds = 5;  // as often they move
    double least_radius = 0.0;  // no child is smaller
};

// Adaptive insertion of surfels (D04 7.2): a leaf beside which the field is not what its slope there says gives way to
// four children, set across the gradient, which then spread out by point repulsion (Turk 1992) without leaving the
// surface or their parent.
class Insertion {
public:
    Insertion(const Scene& scene, SurfelTree& tree, const InsertionOptions& options);

    // One round over all leaves: splits those of which a neighbour's value is off by more than `wanted` (eq. 11), as far
    // as the tree has room, those first that matter most. Both by point. Returns the first of the inserted points.
    std::uint32_t refine(const std::vector<double>& values, const std::vector<double>& wanted);

private:
    bool can_split(std::uint32_t leaf) const;
    std::uint32_t split(const std::vector<std::uint32_t>& leaves, const std::vector<double>& values);
    struct Leaves;
    struct Neighborhood;
    void measure(const Leaves& leaves, std::uint32_t place, const std::vector<double>& values,
                 Neighborhood& out) const;
    void repel(std::uint32_t first);
    Vec3 kept_on_patch(std::uint32_t leaf, const Vec3& wanted) const;

    const Scene& scene_;
    SurfelTree& tree_;
    InsertionOptions options_;
};

}  // namespace surflux
