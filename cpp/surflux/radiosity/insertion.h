#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/radiosity/normal_field.h"
#include "surflux/radiosity/surfel_tree.h"
#include "surflux/radiosity/tuning.h"

namespace surflux {

struct InsertionOptions {
    double least_radius = 0.0;  // no child is smaller
    RefinementTuning tuning = {};
};

// The radius below which no child is inserted: that share of the radius of the scene's surfels (RMS by area).
double smallest_radius(const Surfels& surfels, double share = RefinementTuning{}.smallest_share);
// How many leaves a tree may get, for a scene of n surfels: `most`, but no more than 256 n; if it is 0, 2 n, but no
// more than n + 50 000. Without insertion n.
std::size_t leaves_allowed(const Scene& scene, bool insert, std::size_t most);

// Adaptive insertion of surfels (D04 7.2): a leaf beside which the field is not what its slope there says gives way to
// four children, set across the gradient, which then spread out by point repulsion (Turk 1992) without leaving the
// surface or their parent.
class Insertion {
public:
    Insertion(SurfelTree& tree, const InsertionOptions& options, Team team = {});

    // One round over all leaves: splits those of which a neighbour's value is off by more than what is wanted there
    // (eq. 11); where the tree has no room for all of them down to their end, those alone that matter most. Were there
    // any?
    using OfPoint = std::function<double(std::uint32_t leaf)>;
    bool refine(const OfPoint& value, const OfPoint& wanted, const Progress& progress = {});
    // The same, round after round, with what each changes, until there are none or it has been done that often.
    template <class Changed>
    void refine_all(const OfPoint& value, const OfPoint& wanted, const Changed& changed,
                    const Progress& progress = {}) {
        for (std::size_t left = whole_number(options_.tuning.insertion_rounds);
             left > 0 && refine(value, wanted, progress); --left)
            changed();
    }
    // How many leaves the last round would have split and did not, for want of room.
    std::size_t left_out() const { return left_out_; }
    // Which points refine() asks for a value: those of objects in which any may be split.
    std::vector<char> asked() const;

private:
    bool can_split(std::uint32_t leaf) const;
    struct Leaves;
    bool split(const Leaves& leaves, const std::vector<std::uint32_t>& chosen, const std::vector<double>& values,
               const Progress& progress);
    struct Neighborhood;
    void measure(const Leaves& leaves, std::uint32_t place, const std::vector<double>& values, Neighborhood& out) const;
    double least_weight(const std::vector<std::uint32_t>& leaves, const std::vector<double>& weights) const;
    void repel(std::uint32_t first, const Progress& progress);
    const NormalField& normals();
    Vec3 kept_on_patch(std::uint32_t leaf, const Vec3& wanted) const;

    SurfelTree& tree_;
    InsertionOptions options_;
    Team team_;
    std::unique_ptr<NormalField> normals_;
    std::size_t left_out_ = 0;
};

}  // namespace surflux
