#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "surflux/scene/surfels.h"

namespace surflux {

// Where a disk ends at sharp edges, the two nearest to its centre: dot(normal, p - position) <= limit, as of DiskEnd.
struct Crease {
    Vec3 normal;
    double limit = 1e30;
};
using Creases = std::array<Crease, 2>;

// Of the surfels asked for, by those around of the same object (area/disk_ends.h). `around`: ascending, with all that
// are asked for among them. Borders of the sampling end no disk: another object may adjoin there.
std::vector<Creases> creases_of(const Surfels& surfels, const std::vector<std::int32_t>& objects,
                                const std::vector<std::uint32_t>& asked, const std::vector<std::uint32_t>& around);

}  // namespace surflux
