#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/scene/lights.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/sender_groups.h"

namespace surflux {

struct GroupLightOptions {
    std::size_t rays = 16384;  // shadow rays towards each light
    std::uint64_t seed = 0;
};

// Irradiance of groups of surfels from point, spot, area and directional lights. Unoccluded it is the mean over all
// samples of a group; which share of it arrives is found by shadow rays from a few of them, which are drawn by what
// they would have (a ratio estimator): the more rays, the more of all light the group would send; where that is less
// than one, one group stands for several (Russian roulette). Rays of all groups are traced together.
class GroupLight {
public:
    GroupLight(const CompiledScene& scene, const SenderGroups& groups, const SenderSamples& samples)
        : scene_(scene), groups_(groups), samples_(samples) {}

    // Three channels for each node of the groups, 0 but of leaves. `reflectance`: the same of what they reflect.
    std::vector<float> irradiance(const std::vector<Light>& lights, const std::vector<float>& reflectance,
                                  const GroupLightOptions& options) const;

private:
    const CompiledScene& scene_;
    const SenderGroups& groups_;
    const SenderSamples& samples_;
};

}  // namespace surflux
