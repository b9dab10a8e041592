#include "surflux/area/effective_area.h"

#include "surflux/area/atlas.h"
#include "surflux/area/neighborhood.h"
#include "surflux/area/quadrature.h"
#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/gl/context.h"

namespace surflux {

namespace {

// The geometry of D04 fig. 3b: over y_i = x_i + R_i (s u + t v), y_j = y_i + h n_i with h chosen on disk j's plane.
DiskTerm term_of(const Member& j) {
    const Vec3 d = -1.0 / j.radius * j.position;
    const Vec3& n = j.normal;
    const double step = 1.0 / j.radius;
    const double h0 = -dot(d, n) / n.z, h1 = -step * n.x / n.z, h2 = -step * n.y / n.z;
    // |d + s u + t v + h n_i|^2 with h = h0 + h1 s + h2 t.
    DiskTerm term;
    term.c00 = static_cast<float>(dot(d, d) + 2.0 * h0 * d.z + h0 * h0);
    term.c10 = static_cast<float>(2.0 * d.x * step + 2.0 * h1 * d.z + 2.0 * h0 * h1);
    term.c01 = static_cast<float>(2.0 * d.y * step + 2.0 * h2 * d.z + 2.0 * h0 * h2);
    term.c20 = static_cast<float>(step * step + h1 * h1);
    term.c11 = static_cast<float>(2.0 * h1 * h2);
    term.c02 = static_cast<float>(step * step + h2 * h2);
    term.stretch = static_cast<float>(1.0 / n.z);
    return term;
}

Sharer sharer_of(const Member& j) {
    return {static_cast<float>(j.position.x), static_cast<float>(j.position.y), static_cast<float>(j.position.z),
            static_cast<float>(1.0 / (j.radius * j.radius))};
}

CurvedSurface single_precision(const SurfaceModel& m) {
    return {static_cast<float>(m.kxx), static_cast<float>(m.kxy), static_cast<float>(m.kyy),
            static_cast<float>(m.gx),  static_cast<float>(m.gy),  static_cast<float>(m.z0)};
}

// Where each direction of the grid leaves the disk or one of the half planes.
void ends_along(const std::vector<HalfPlane>& half_planes, const PolarGrid& grid, std::vector<float>& ends) {
    ends.assign(static_cast<std::size_t>(grid.directions), 1.0f);
    for (const HalfPlane& h : half_planes) {
        const auto x = static_cast<float>(h.x), y = static_cast<float>(h.y), limit = static_cast<float>(h.limit);
        for (std::size_t d = 0; d < ends.size(); ++d) {
            const float towards = x * grid.cosine[d] + y * grid.sine[d];
            if (towards * ends[d] > limit) ends[d] = limit / towards;
        }
    }
}

// What a CPU thread weighs in about a second, in disks times resolution^2: some 100 000 disks at resolution 32.
constexpr double points_per_second = 1e8;

bool gl_is_faster(std::size_t disks, int resolution) {
    const double points = static_cast<double>(disks) * resolution * resolution;
    if (points < points_per_second * thread_count() || !gl::has_gpu_driver()) return false;
    try {
        return !gl::is_software(gl::describe());
    } catch (const DeviceError&) {
        return false;
    }
}

}  // namespace

std::vector<double> effective_areas(const Surfels& surfels, const AreaOptions& options, const Progress& progress) {
    const double steepest = options.method == AreaMethod::paper ? 80.0 : 8.0;  // beyond, floats overflow
    require(options.kappa > 0.0 && options.kappa <= steepest, "kappa: wanted in (0, ", steepest, "], got ",
            options.kappa);
    require(options.resolution >= 4 && options.resolution <= max_resolution, "resolution: wanted between 4 and ",
            max_resolution, ", got ", options.resolution);
    require(options.epsilon > 0.0 && options.epsilon < 1.0, "epsilon: wanted in (0, 1), got ", options.epsilon);

    std::vector<double> areas(surfels.size(), 0.0);
    std::vector<bool> is_disk(surfels.size(), true);
    for (const Triangle& t : surfels.triangles) {
        areas[t.surfel] += area_of(t);
        is_disk[t.surfel] = false;
    }
    const NeighborhoodFinder finder(surfels, is_disk, options.epsilon);
    const std::vector<std::uint32_t>& disks = finder.disks();
    const bool with_gl = options.backend == AreaBackend::gl ||
                         (options.backend == AreaBackend::automatic && gl_is_faster(disks.size(), options.resolution));
    if (with_gl) {
        const std::vector<float> shares = atlas_shares(finder, options, progress);
        for (std::size_t k = 0; k < disks.size(); ++k) {
            const double radius = surfels.radii[disks[k]];
            areas[disks[k]] = radius * radius * static_cast<double>(shares[k]);
        }
        return areas;
    }
    const PolarGrid grid(options.resolution);
    const auto kappa = static_cast<float>(options.kappa);
    parallel_blocks(
        disks.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            Neighborhood around;
            std::vector<DiskTerm> terms;
            std::vector<Sharer> sharers;
            std::vector<float> ends;
            for (std::size_t k = begin; k < end; ++k) {
                const std::uint32_t i = disks[k];
                double share = 0.0;
                if (options.method == AreaMethod::paper) {
                    finder.flat(i, around);
                    terms.clear();
                    for (const Member& j : around.surface) terms.push_back(term_of(j));
                    share = integrate_paper(terms.data(), terms.size(), kappa, options.resolution);
                } else {
                    finder.curved(i, around);
                    sharers.clear();
                    for (const Member& j : around.surface) sharers.push_back(sharer_of(j));
                    for (const Member& j : around.crease) sharers.push_back(sharer_of(j));
                    ends_along(around.ends, grid, ends);
                    share = integrate_curved(single_precision(around.model), sharers.data(), sharers.size(),
                                             ends.data(), kappa, grid);
                }
                areas[i] = surfels.radii[i] * surfels.radii[i] * share;
            }
        },
        progress);
    return areas;
}

}  // namespace surflux
