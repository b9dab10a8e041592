#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"
#include "surflux/radiosity/tuning.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/sight.h"

namespace surflux {

// Groups of surfels, groups of those, and so on (D04 section 6): every surfel is in one group of each level.
struct Hierarchy {
    // Level 0 groups surfels, level k the groups of level k - 1; either are its members.
    struct Level {
        std::vector<std::uint32_t> parent_of;       // of each member, its group here
        std::vector<std::uint32_t> first, members;  // those of group g are members[first[g] .. first[g + 1]), the one
                                                    // it was grown from first, the others ascending
        std::vector<Vec3> positions, normals;       // averages by area; normals unit
        std::vector<double> radii;  // of a sphere around the average position that encloses all disks (D03 sec. 6)
        std::vector<double> areas;  // sums
        std::vector<std::uint32_t> representatives;  // the surfel nearest the averages, by place and by normal

        std::size_t size() const { return positions.size(); }
    };
    std::vector<Level> levels;  // finest first, at least one; surfels themselves are not among them

    // The group of each surfel on a level.
    std::vector<std::uint32_t> groups(std::size_t level) const;
};

struct HierarchyOptions {
    double epsilon = 0.8;    // cosine between normals above which surfels group (D04 eq. 10), -1 < epsilon < 1
    int max_levels = 0;      // at most so many; 0: to one group, or to where a level hardly shrinks
    std::uint64_t seed = 0;  // of the order in which groups are grown
    double least_shrinking = RefinementTuning{}.least_shrinking;  // from level to level
};

// Do two surfels share the air over them?
using JoinedSurfels = std::function<bool(std::uint32_t i, std::uint32_t j)>;

// Needs areas. `object`: one number each; surfels of different objects stay apart, and so does, where `joined` is
// given, what has a wall between it: a surfel, or the one that stands for a group, is only taken by one that it is
// joined with.
Hierarchy build_hierarchy(const Surfels& surfels, const std::vector<std::uint32_t>& object,
                          const HierarchyOptions& options, const Progress& progress = nullptr,
                          const JoinedSurfels& joined = nullptr);
// Of a scene: no group spans a wall, so that what one side has is not sent on the other, nor given to it.
Hierarchy build_hierarchy(const Scene& scene, const Sight& sight, const HierarchyOptions& options,
                          const Progress& progress);

}  // namespace surflux
