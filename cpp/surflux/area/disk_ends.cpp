#include "surflux/area/disk_ends.h"

#include "surflux/area/neighborhood.h"
#include "surflux/core/parallel.h"

namespace surflux {

namespace {

// How far disks go on beyond a crease, over their radius: no ray slips between the two sides, and what sticks out is
// too small to matter.
constexpr double crease_overlap = 0.02;

}  // namespace

void find_disk_ends(Surfels& surfels, double epsilon, const Progress& progress) {
    const NeighborhoodFinder finder(surfels, disks_among(surfels), epsilon);
    std::vector<std::vector<DiskEnd>> of_surfel(surfels.size());
    std::vector<char> alone(surfels.size(), 0);
    parallel_blocks(
        finder.size(), 16,
        [&](std::size_t begin, std::size_t end) {
            Neighborhood around;
            for (std::size_t k = begin; k < end; ++k) {
                finder.find(k, true, around);
                const std::uint32_t i = finder.surfel(k);
                alone[i] = around.surface.size() == 1 && around.crease.empty() && around.ends.empty();
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
    surfels.ends.clear();
    surfels.alone.clear();
    for (std::uint32_t i = 0; i < surfels.size(); ++i) {
        surfels.ends.insert(surfels.ends.end(), of_surfel[i].begin(), of_surfel[i].end());
        if (alone[i]) surfels.alone.push_back(i);
    }
}

}  // namespace surflux
