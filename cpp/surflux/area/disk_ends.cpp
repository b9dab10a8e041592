#include "surflux/area/disk_ends.h"

#include <algorithm>

#include "surflux/area/disk_integrator.h"
#include "surflux/area/neighborhood.h"
#include "surflux/core/parallel.h"

namespace surflux {

namespace {

// How far disks go on beyond a crease, over their radius: no ray slips between the two sides, and what sticks out is
// too small to matter.
constexpr double crease_overlap = 0.02;

// Where disks end, taken one by one; on many threads, as long as each takes others.
class EndsOfDisks {
public:
    explicit EndsOfDisks(const Surfels& surfels)
        : surfels_(surfels), of_surfel_(surfels.size()), alone_(surfels.size(), 0) {}

    void take(Span<std::uint32_t> pile, const Neighborhood& around) {
        for (const std::uint32_t i : pile) take(i, around);
    }

    void take(std::uint32_t i, const Neighborhood& around) {
        alone_[i] = around.surface.size() == 1 && around.crease.empty() && around.ends.empty();
        for (std::size_t e = 0; e < around.ends.size(); ++e) {
            const HalfPlane& side = around.ends[e];
            const auto kind = e < around.crease_ends ? DiskEnd::crease : DiskEnd::border;
            const double overlap = kind == DiskEnd::crease ? crease_overlap * surfels_.radii[i] : 0.0;
            const double limit = side.limit * around.radius + overlap;
            if (limit < surfels_.radii[i])
                of_surfel_[i].push_back({side.x * around.frame.u + side.y * around.frame.v, limit, i, kind});
        }
    }

    DiskEnds all() const {
        DiskEnds out;
        for (std::uint32_t i = 0; i < of_surfel_.size(); ++i) {
            out.ends.insert(out.ends.end(), of_surfel_[i].begin(), of_surfel_[i].end());
            if (alone_[i]) out.alone.push_back(i);
        }
        return out;
    }

private:
    const Surfels& surfels_;
    std::vector<std::vector<DiskEnd>> of_surfel_;
    std::vector<char> alone_;
};

// Calls visit(disk, neighbourhood) for every disk of the finder; what makes `state` is called once for each block of
// them.
template <class MakeState, class Visit>
void for_disks(const NeighborhoodFinder& finder, const MakeState& make_state, const Visit& visit,
               const Progress& progress) {
    parallel_blocks(
        finder.size(), 16,  // few: where radii are so large that all disks reach all, each takes long
        [&](std::size_t begin, std::size_t end) {
            auto state = make_state();
            Neighborhood around;
            for (std::size_t k = begin; k < end; ++k) {
                finder.find(k, true, around);
                visit(state, k, around);
            }
        },
        progress);
}

}  // namespace

DiskEnds find_disk_ends(const Surfels& surfels, double epsilon, const Progress& progress) {
    const NeighborhoodFinder finder(surfels, disks_among(surfels), epsilon, standing_at(0, surfels.size(), progress));
    EndsOfDisks ends(surfels);
    for_disks(
        finder, [] { return 0; },
        [&](int, std::size_t k, const Neighborhood& around) { ends.take(finder.surfels(k), around); }, progress);
    return ends.all();
}

DiskEnds find_areas_and_ends(const Surfels& surfels, std::vector<double>& areas, const std::vector<char>& wanted,
                             const Progress& progress) {
    const AreaOptions options;
    const NeighborhoodFinder finder(surfels, disks_among(surfels), options.epsilon,
                                    standing_at(0, surfels.size(), progress));
    require_radii(finder);
    const PolarGrid grid(options.resolution);
    EndsOfDisks ends(surfels);
    areas = patch_areas(surfels);
    for_disks(
        finder, [&] { return DiskIntegrator(options, grid); },
        [&](DiskIntegrator& integrator, std::size_t k, const Neighborhood& around) {
            ends.take(finder.surfels(k), around);
            const Span<std::uint32_t> pile = finder.surfels(k);
            const auto is_wanted = [&](std::uint32_t i) { return wanted.empty() || wanted[i]; };
            if (std::any_of(pile.begin(), pile.end(), is_wanted))
                take_area(finder, k, options.method, integrator.area(around), areas);
        },
        progress);
    return ends.all();
}

}  // namespace surflux
