#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/random.h"
#include "surflux/lights/emitter.h"
#include "surflux/lights/narrow_light.h"
#include "surflux/scene/lights.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/sender_groups.h"

namespace surflux {

struct ShadowRays;

struct GroupLightOptions {
    std::size_t rays = 16384;  // shadow rays towards each light, about; of wide ones up to four times as many
    std::uint64_t seed = 0;
    bool shares_narrow = true;   // among disks, of lamps close to some and of narrow spots (NarrowLight)
    bool shares_across = false;  // a ray among groups that a wall parts, too: right on the mean alone
};

// Irradiance of groups of surfels from point, spot, area and directional lights. Unoccluded it is the mean over all
// samples of a group or, where these are too few to tell it, over its surfels in closed form; which share of it arrives
// is found by shadow rays from some of them, drawn by what they would have (a ratio estimator): the more rays, the more
// of all light the group would send. Where that is less than a ray, groups that are neighbours in the tree share one,
// so that what a ray says is never more than there may be; but not across walls (SenderGroups::Node::is_walled): of
// what these leave next to nothing, some groups are drawn and count for the others, which is right on the mean.
class GroupLight {
public:
    // `areas`: what of each surfel receives light. All must live as long.
    GroupLight(const CompiledScene& scene, const SenderGroups& groups, const SenderSamples& samples,
               const SurfelPoints& points, const std::vector<double>& areas);

    // `colors` for each node of the groups, 0 but of leaves. `reflectance`: the same of what they reflect.
    std::vector<float> irradiance(const std::vector<Light>& lights, const std::vector<float>& reflectance,
                                  const GroupLightOptions& options) const;

private:
    // Calls visit(surfel) for those of a leaf that receive light.
    template <class Visit>
    void for_lit(std::size_t leaf, const Visit& visit) const {
        for (std::uint32_t k = first_lit_[leaf]; k < first_lit_[leaf + 1]; ++k) visit(lit_[k].surfel);
    }
    void describe(std::size_t leaf);
    Receiver whole(std::uint32_t surfel) const;
    struct Unoccluded;  // light of all samples
    void find_unoccluded(const Emitter& light, const NarrowLight& narrow, const std::vector<float>& reflectance,
                         std::uint64_t seed, Unoccluded& out) const;
    void find_beam(const Emitter& light, const NarrowLight& narrow, std::size_t leaf, std::uint64_t seed,
                   Unoccluded& out) const;
    double mean_over_surfels(const Emitter& light, const NarrowLight& narrow, std::size_t leaf) const;
    double wide_share(const Unoccluded& light) const;
    std::size_t wide_samples(const Unoccluded& light, std::size_t leaf) const;
    Vec3 end_of(const Emitter& emitter, std::size_t sample, Random& random) const;
    void aim(const ShadowRays& shot, const Unoccluded& light, std::uint64_t seed,
             std::vector<std::size_t>& samples) const;

    const CompiledScene& scene_;
    const SenderGroups& groups_;
    const SenderSamples& samples_;
    const SurfelPoints& points_;
    const std::vector<double>& areas_;
    std::vector<std::uint32_t> number_;  // of each node that is a leaf
    // What of a surfel is asked for where light is uneven in its leaf, leaf by leaf: to fetch it from where surfels are
    // takes half of the time.
    struct LitSurfel {
        std::uint32_t surfel;
        float from_center[3], normal[3], radius, area;
    };
    std::vector<LitSurfel> lit_;
    std::vector<std::uint32_t> first_lit_;  // of each leaf, and the end
    struct Extent {
        NormalCone normals;
        double radius = 0.0;  // of a sphere around its center
    };
    std::vector<Extent> extents_;  // of what each leaf has that receives light
    bool has_disks_ = false;
};

}  // namespace surflux
