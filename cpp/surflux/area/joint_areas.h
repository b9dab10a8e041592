#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/scene.h"

namespace surflux {

struct JointShares {
    std::vector<std::uint32_t> kept;  // objects whose areas stay, ascending
    std::vector<DiskEnd> borders;     // of all joined disks, in place of those that they have in their objects
};

// Where disks of several objects sample one surface (disk_overlap.h), they share it by the partition of unity that
// effective areas are made of, as if all were of one object: the more points one has there, the larger its part. Each
// disk counts as far as in its own object, and ends where it ends there, but for borders beside which another object
// goes on at once, as slices of a cloud do: what lies between the two is theirs.
//
// Multiplies the shares of joined disks by the area that each has among all, over that which it has in its own object.
// Areas of an object that fit the former, and better, are such parts already, as those of a slice of a cloud are, and
// stay. The scene has areas and spreads; of objects marked in `has_own_areas` the areas are those of effective_areas().
JointShares take_joint_shares(const Scene& scene, const std::vector<char>& is_joined, std::vector<double>& shares,
                              const std::vector<char>& has_own_areas = {}, const Progress& progress = {});

}  // namespace surflux
