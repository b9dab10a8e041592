#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "surflux/transfer/sender_groups.h"

namespace surflux {

// Rays of a node of the groups towards a light, which tell for all below it how much of the light arrives.
struct ShadowRays {
    std::uint32_t node;
    std::uint32_t rays;  // more than one of leaves alone
    float weight;        // one over the chance of having been drawn
};

// A cut through the tree below which each node has a ray or, of leaves, more, up to most_rays(leaf): about `rays` in
// all, in proportion to `power`, what each node would send. Where a ray arrives on one side of a wall says nothing of
// the other, so that groups are cut at walls unless rays are shared `across`.
std::vector<ShadowRays> plan_shadow_rays(const SenderGroups& groups, const std::vector<float>& power, std::size_t rays,
                                         bool across, std::uint64_t seed,
                                         const std::function<std::size_t(std::uint32_t)>& most_rays);

}  // namespace surflux
