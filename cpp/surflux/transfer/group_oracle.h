#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

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
    // `light`: how much is expected on each surfel, by area; alike on all where empty.
    GroupOracle(const Surfels& surfels, const SurfelPoints& points, const Tracer& tracer, bool distant,
                std::uint64_t seed, std::vector<double> light = {})
        : surfels_(surfels),
          points_(points),
          tracer_(tracer),
          distant_(distant),
          seed_(seed),
          light_(std::move(light)) {}

    // By pairs of members, of which there are some; the lamp is where one of them expects it. `stream`: of the random
    // numbers of this group.
    SenderGroups::Lit unlikeness(const std::uint32_t* members, std::size_t count, std::uint64_t stream) const;
    // Does what stands between members up to `middle` and those from there on hide all lamps close to one of them from
    // all others, as far as some pairs tell? So walls of a house do with a ground that goes on beneath them, and bumps
    // and columns do not.
    // `reach`: how close the lamps are, by the distance of both members.
    bool walled(const std::uint32_t* members, std::size_t middle, std::size_t count, std::uint64_t stream,
                double reach = 1.0) const;
    // Does such a wall go through a group? Lamps go from one member to the next near one that sees them: a part that
    // they do not leave may lie beyond one. Of a large group some members tell that there may be one, and not where.
    SenderGroups::Sides sides(const std::uint32_t* members, std::size_t count, std::uint64_t stream) const;
    // What groups ask of it, which must live as long. `of_halves`: for groups that share shadow rays, under lamps.
    SenderGroups::Walls walls(bool of_halves) const;

private:
    class Draw;  // of members
    Departure place_on(std::uint32_t surfel, Random& random) const;
    Departure center_of(std::uint32_t surfel) const {
        return {surfels_.positions[surfel], surfels_.normals[surfel], surfel};
    }
    enum class Seen { yes, no, behind };
    // A lamp close to one, from the other.
    Seen see(const Departure& from, const Departure& lit, double reach, Random& random) const;
    // Of surfels, those that lamps reach from one to the next near one.
    struct Parts {
        std::vector<std::size_t> of;  // the number of each one's part
        std::size_t count = 0;
        bool hidden = false;  // was one, of a lamp?
    };
    Parts parts(const std::vector<std::uint32_t>& surfels, Random& random) const;
    // Along a random ray, to what it meets, or so far.
    Vec3 free_way(const Departure& from, double most, double u, double v) const;

    const Surfels& surfels_;
    const SurfelPoints& points_;
    const Tracer& tracer_;
    bool distant_;
    std::uint64_t seed_;
    std::vector<double> light_;
};

}  // namespace surflux
