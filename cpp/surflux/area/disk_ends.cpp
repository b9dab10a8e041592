#include "surflux/area/disk_ends.h"

#include "surflux/area/neighborhood.h"
#include "surflux/core/parallel.h"

namespace surflux {

namespace {

// How far disks go on beyond a crease, over their radius: no ray slips between the two sides, and what sticks out is
// too small to matter.
constexpr double crease_overlap = 0.02;

}  // namespace

std::vector<DiskEnd> disk_ends(const Surfels& surfels, double epsilon, const Progress& progress) {
    const NeighborhoodFinder finder(surfels, disks_among(surfels), epsilon);
    std::vector<std::vector<DiskEnd>> of_surfel(surfels.size());
    parallel_blocks(
        finder.size(), 16,
        [&](std::size_t begin, std::size_t end) {
            Neighborhood around;
            for (std::size_t k = begin; k < end; ++k) {
                finder.find(k, true, around);
                const std::uint32_t i = finder.surfel(k);
                for (std::size_t e = 0; e < around.ends.size(); ++e) {
                    const HalfPlane& side = around.ends[e];
                    const auto kind = e < around.crease_ends ? DiskEnd::crease : DiskEnd::border;
                    const double overlap = kind == DiskEnd::crease ? crease_overlap * surfels.radii[i] : 0.0;
                    const double limit = side.limit * around.radius + overlap;
                    if (limit < surfels.radii[i])
                        of_surfel[i].push_back({side.x * around.frame.u + side.y * around.frame.v, limit, i, kind});
                }
            }
        },
        progress);
    std::vector<DiskEnd> out;
    for (const auto& ends : of_surfel) out.insert(out.end(), ends.begin(), ends.end());
    return out;
}

}  // namespace surflux
