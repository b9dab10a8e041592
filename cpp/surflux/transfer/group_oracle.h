#pragma once

#include <cstddef>
#include <cstdint>

#include "surflux/core/random.h"
#include "surflux/lights/sample_points.h"
#include "surflux/scene/surfels.h"
#include "surflux/trace/tracer.h"
#include "surflux/transfer/sender_groups.h"

namespace surflux {

// How much the light of a lamp differs between two surfels of a group: the sender's half of L07's oracle (6.5). A lamp
// is put where one of them sees it, at random along a ray over its hemisphere, or far away where that leaves the scene.
class GroupOracle {
public:
    GroupOracle(const Surfels& surfels, const SurfelPoints& points, const Tracer& tracer, bool distant,
                std::uint64_t seed)
        : surfels_(surfels), points_(points), tracer_(tracer), distant_(distant), seed_(seed) {}

    // By pairs of members, of which there are some. `stream`: of the random numbers of this group.
    SenderGroups::Lit unlikeness(const std::uint32_t* members, std::size_t count, std::uint64_t stream) const;
    // Does what stands between members up to `middle` and those from there on hide all lamps close to one of them from
    // all others, as far as some pairs tell? So walls of a house do with a ground that goes on beneath them, and bumps
    // and columns do not.
    bool walled(const std::uint32_t* members, std::size_t middle, std::size_t count, std::uint64_t stream) const;

private:
    Departure place_on(std::uint32_t surfel, Random& random) const;
    // Along a random ray, to what it meets, or so far.
    Vec3 free_way(const Departure& from, double most, double u, double v) const;

    const Surfels& surfels_;
    const SurfelPoints& points_;
    const Tracer& tracer_;
    bool distant_;
    std::uint64_t seed_;
};

}  // namespace surflux
