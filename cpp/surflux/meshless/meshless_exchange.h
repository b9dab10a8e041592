#pragma once

#include <cstdint>
#include <vector>

#include "surflux/meshless/hemisphere_gather.h"
#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/receivers.h"
#include "surflux/meshless/surfel_means.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/reciprocal_scaling.h"

namespace surflux {

// The exchange of light between surfels by way of the rows of receivers: what is needed to keep its energy.
class MeshlessExchange {
public:
    MeshlessExchange(const Scene& scene, const MultilevelBasis& basis, const SurfelMeans& means,
                     const Receivers& receivers, const HemisphereGather& gather);

    // The connected part of each row: of those that one is gathered from by way of a surfel.
    const std::vector<std::uint32_t>& parts() const { return parts_; }
    std::uint32_t part_of_surfel(std::size_t i) const { return part_of_surfel_[i]; }
    // Factors of surfels (solution/reciprocal_scaling.h), of which each sends `sent` of the light in the basis, and
    // what rays find beside that.
    ReciprocalScaling scale_by_reciprocity(const std::vector<Rgb>& sent) const;
    // Factors of what surfels send of light that is not in the basis, on top of those: receivers close by gather it
    // where rays end and far ones as means, of which they may see the brighter part.
    std::vector<double> lit_scale(const ReciprocalScaling& scaling) const;

    // By the finest level on which light was gathered around a surfel.
    HemisphereLoss loss(std::uint32_t surfel) const;
    // What rays found of emitters, as a surfel has it; all channels added up.
    double from_emitters(std::uint32_t surfel) const { return means_.mean(surfel, found_).z; }

private:
    void find_parts();
    void find_areas();
    template <class Visit>
    void for_finest_rows(std::uint32_t surfel, const Visit& visit) const;

    const Scene& scene_;
    const MultilevelBasis& basis_;
    const SurfelMeans& means_;
    const Receivers& receivers_;
    const HemisphereGather& gather_;
    std::vector<std::uint32_t> parts_, part_of_surfel_;
    std::vector<double> areas_;  // that each row stands for
    std::vector<Rgb> found_;     // coefficients of what escapes, what backs absorb, and what emitters bring
};

}  // namespace surflux
