#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/lights/emitter.h"
#include "surflux/scene/lights.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/sender_groups.h"

namespace surflux {

struct GroupLightOptions {
    std::size_t rays = 16384;  // shadow rays towards each light, about
    std::uint64_t seed = 0;
};

// Irradiance of groups of surfels from point, spot, area and directional lights. Unoccluded it is the mean over all
// samples of a group; which share of it arrives is found by shadow rays from some of them, drawn by what they would
// have (a ratio estimator): the more rays, the more of all light the group would send. Where that is less than a ray,
// groups that are neighbours in the tree share one, so that what a ray says is never more than there may be.
class GroupLight {
public:
    GroupLight(const CompiledScene& scene, const SenderGroups& groups, const SenderSamples& samples);

    // `colors` for each node of the groups, 0 but of leaves. `reflectance`: the same of what they reflect.
    std::vector<float> irradiance(const std::vector<Light>& lights, const std::vector<float>& reflectance,
                                  const GroupLightOptions& options) const;

private:
    struct Unoccluded;  // light of all samples
    struct Shot;        // rays of a node
    Unoccluded unoccluded(const Emitter& light, const std::vector<float>& reflectance, std::uint64_t seed) const;
    std::vector<Shot> plan(const Unoccluded& light, std::size_t rays) const;
    void aim(const Shot& shot, const Unoccluded& light, std::uint64_t seed, std::vector<std::size_t>& samples) const;

    const CompiledScene& scene_;
    const SenderGroups& groups_;
    const SenderSamples& samples_;
    std::vector<std::uint32_t> number_;  // of each node that is a leaf
};

}  // namespace surflux
