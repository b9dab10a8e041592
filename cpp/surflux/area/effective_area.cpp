#include "surflux/area/effective_area.h"

#include <algorithm>

#include "surflux/area/atlas.h"
#include "surflux/area/disk_integrator.h"
#include "surflux/area/neighborhood.h"
#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/gl/context.h"

namespace surflux {

namespace {

bool takes_gl(std::size_t disks, const AreaOptions& options) {
    if (options.backend != AreaBackend::automatic) return options.backend == AreaBackend::gl;
    if (!atlas_may_pay(disks, options, thread_count()) || !gl::has_gpu_driver()) return false;
    try {
        return !gl::is_software(gl::describe());
    } catch (const DeviceError&) {
        return false;
    }
}

}  // namespace

void check(const AreaOptions& options) {
    const double steepest = options.method == AreaMethod::paper ? 80.0 : 8.0;  // beyond, floats overflow
    require(options.kappa > 0.0 && options.kappa <= steepest, "kappa: wanted in (0, ", steepest, "], got ",
            options.kappa);
    require(options.resolution >= 4 && options.resolution <= max_resolution, "resolution: wanted between 4 and ",
            max_resolution, ", got ", options.resolution);
    require(options.epsilon > 0.0 && options.epsilon < 1.0, "epsilon: wanted in (0, 1), got ", options.epsilon);
}

std::vector<bool> disks_among(const Surfels& surfels) {
    std::vector<bool> is_disk(surfels.size(), true);
    for (const Triangle& t : surfels.triangles) is_disk[t.surfel] = false;
    return is_disk;
}

std::vector<double> patch_areas(const Surfels& surfels) {
    std::vector<double> areas(surfels.size(), 0.0);
    for (const Triangle& t : surfels.triangles) areas[t.surfel] += area_of(t);
    return areas;
}

void take_area(const NeighborhoodFinder& finder, std::size_t disk, AreaMethod method, double area,
               std::vector<double>& areas) {
    const double radius = finder.radius(disk);
    if (method == AreaMethod::curved) area = std::min(area, pi * radius * radius);
    const Span<std::uint32_t> pile = finder.surfels(disk);
    for (const std::uint32_t i : pile) areas[i] = area / static_cast<double>(pile.size());
}

void require_radii(const NeighborhoodFinder& finder) {
    double largest = 0.0;
    for (std::size_t k = 0; k < finder.size(); ++k) largest = std::max(largest, finder.radius(k));
    constexpr double least = 1e-30, most = 1e30;
    require(finder.size() == 0 || (largest >= least && largest <= most), "radii: the largest is ", largest,
            ", wanted between ", least, " and ", most, "; choose other units");
}

std::vector<double> effective_areas(const Surfels& surfels, const AreaOptions& options, const Progress& progress) {
    check(options);
    std::vector<double> areas = patch_areas(surfels);
    const NeighborhoodFinder finder(surfels, disks_among(surfels), options.epsilon,
                                    standing_at(0, surfels.size(), progress));
    require_radii(finder);
    if (takes_gl(finder.size(), options)) {
        const std::vector<double> drawn = atlas_areas(finder, options, progress);
        for (std::size_t k = 0; k < finder.size(); ++k) take_area(finder, k, options.method, drawn[k], areas);
        return areas;
    }
    const PolarGrid grid(options.resolution);
    parallel_blocks(
        finder.size(), 16,  // few: where radii are so large that all disks reach all, each takes long
        [&](std::size_t begin, std::size_t end) {
            DiskIntegrator integrator(options, grid);
            Neighborhood around;
            for (std::size_t k = begin; k < end; ++k) {
                finder.find(k, options.method == AreaMethod::curved, around);
                take_area(finder, k, options.method, integrator.area(around), areas);
            }
        },
        progress);
    return areas;
}

}  // namespace surflux
