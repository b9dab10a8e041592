#pragma once

#include <cstdint>
#include <vector>

#include "surflux/meshless/hemisphere_gather.h"
#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/receivers.h"
#include "surflux/meshless/surfel_means.h"
#include "surflux/meshless/surfel_refinement.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/power_balance.h"
#include "surflux/solution/reciprocal_scaling.h"
#include "surflux/solution/solution.h"

namespace surflux {

// Energy conservation of solve_meshless. Receivers' rows (HemisphereGather), interpolated to surfels by the basis, are
// a transport operator between surfels. Its rows conserve energy, as rays are counted; its columns, what a surfel sends
// to all others, need not: they have the rays' variance, and the bias of interpolation at edges (RayExchange). This
// finds the factors that scale its columns, and what they are made from: connected components, the area that each row
// stands for, what each surfel loses out of the scene and to backs. HemisphereGather applies them.
class MeshlessExchange {
public:
    MeshlessExchange(const Scene& scene, const MultilevelBasis& basis, const SurfelMeans& means,
                     const Receivers& receivers, const HemisphereGather& gather, const Progress& progress = {});

    // The connected component of each row, in the graph of which row gathers from which by way of surfels.
    const std::vector<std::uint32_t>& parts() const { return parts_; }
    // Sinkhorn factors of surfels as senders (solution/reciprocal_scaling.h), for the light that they send when the
    // basis has `coefficients`: what they reflect of it, and of the light that is not in the basis.
    ReciprocalScaling scale_by_reciprocity(const std::vector<Rgb>& coefficients, const ReciprocityTuning& tuning,
                                           const Progress& progress) const;
    // Factors on top of those, by group of senders: the power that should arrive from the group over the power that
    // does, to the exponent of senders' weight (ReciprocalScaling::Variances). They mend senders' means: receivers
    // close by gather where rays end and far ones by means, of which they may see the brighter part. What should
    // arrive: what leaves the group and is not lost. Groups with wide patches in one connected part share the factor of
    // the light with `coefficients`. Rows are scaled by then.
    HemisphereGather::SenderPower sender_power(const ReciprocalScaling& scaling,
                                               const std::vector<Rgb>& coefficients) const;

    // Where the power went; of surfels that have rays of their own, by those, unless some of these leave from places
    // inside geometry, which send nothing. Rows may have been forgotten by then.
    Figures power(const Solution& solution, const SurfelRefinement& refinement) const;

private:
    double reflected(std::uint32_t surfel, const std::vector<Rgb>& coefficients) const;
    double exitance(std::uint32_t surfel) const { return per_outside(surfel, gather_.exitance(surfel)); }
    double per_outside(std::uint32_t surfel, double exitance) const;
    void share_among_wide(const ReciprocalScaling& scaling, const std::vector<Rgb>& coefficients,
                          const std::vector<Rgb>& sent, const std::vector<double>& sends,
                          std::vector<double>& arrived) const;
    void find_parts(const Progress& progress);
    void find_areas();
    HemisphereLoss loss(std::uint32_t surfel) const;  // by the finest level on which light was gathered around it
    template <class Visit>
    void for_finest_rows(std::uint32_t surfel, const Visit& visit) const;

    const Scene& scene_;
    const MultilevelBasis& basis_;
    const SurfelMeans& means_;
    const Receivers& receivers_;
    const HemisphereGather& gather_;
    std::vector<std::uint32_t> parts_, part_of_surfel_;
    std::vector<HemisphereLoss> losses_;  // of each surfel
    std::vector<double> areas_;           // that each row stands for
    std::vector<Rgb> found_;              // coefficients of what escapes, and of what backs absorb
};

}  // namespace surflux
