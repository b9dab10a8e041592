#include "surflux/area/effective_area.h"

#include "surflux/area/quadrature.h"
#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/neighbors/disk_index.h"

namespace surflux {

namespace {

// Cosine between the normals on either side of the sharpest crease over which surfels share their surroundings;
// excludes the far side of a thin sheet.
constexpr double sharpest_crease = -0.5;

// The geometry of D04 fig. 3b: over y_i = x_i + R_i (s u + t v), y_j = y_i + h n_i with h chosen on disk j's plane.
DiskTerm term_of(const Surfels& surfels, std::uint32_t i, const Frame& frame, std::uint32_t j) {
    const Vec3& n_i = surfels.normals[i];
    const Vec3& n_j = surfels.normals[j];
    const double r_i = surfels.radii[i], r_j = surfels.radii[j];
    const Vec3 d = (surfels.positions[i] - surfels.positions[j]) / r_j;
    const Vec3 u = frame.u * (r_i / r_j), v = frame.v * (r_i / r_j);
    const double cosine = dot(n_i, n_j);
    const double h0 = -dot(d, n_j) / cosine, h1 = -dot(u, n_j) / cosine, h2 = -dot(v, n_j) / cosine;
    const double lift = dot(d, n_i);
    const double scale = dot(u, u);
    // |d + s u + t v + h n_i|^2 with h = h0 + h1 s + h2 t and u, v perpendicular to n_i.
    DiskTerm term;
    term.c00 = static_cast<float>(dot(d, d) + 2.0 * h0 * lift + h0 * h0);
    term.c10 = static_cast<float>(2.0 * dot(d, u) + 2.0 * h1 * lift + 2.0 * h0 * h1);
    term.c01 = static_cast<float>(2.0 * dot(d, v) + 2.0 * h2 * lift + 2.0 * h0 * h2);
    term.c20 = static_cast<float>(scale + h1 * h1);
    term.c11 = static_cast<float>(2.0 * h1 * h2);
    term.c02 = static_cast<float>(scale + h2 * h2);
    term.stretch = static_cast<float>(1.0 / cosine);
    return term;
}

CurvedTerm curved_term_of(const Surfels& surfels, std::uint32_t i, const Frame& frame, std::uint32_t j) {
    const double r_i = surfels.radii[i];
    const Vec3 d = (surfels.positions[j] - surfels.positions[i]) / r_i;
    const Vec3& n = surfels.normals[j];
    const auto in_frame = [](double x) { return static_cast<float>(x); };
    return {in_frame(dot(d, frame.u)),
            in_frame(dot(d, frame.v)),
            in_frame(dot(d, frame.n)),
            in_frame(dot(n, frame.u)),
            in_frame(dot(n, frame.v)),
            in_frame(dot(n, frame.n)),
            static_cast<float>(r_i / surfels.radii[j])};
}

// Disk i and those that share it, closer than their radii reach: i itself, then its neighbours on the same surface
// (n_i . n_j > epsilon), whose number with i is returned; then those around a crease.
std::size_t sharing(const Surfels& surfels, const DiskIndex& index, const std::vector<std::uint32_t>& disks,
                    std::uint32_t i, double epsilon, std::vector<Neighbor>& near, std::vector<std::uint32_t>& out) {
    near.clear();
    index.reaching(surfels.positions[i], surfels.radii[i], near);
    out.assign(1, i);
    const auto take = [&](double above, double up_to) {
        for (const Neighbor& n : near) {
            const std::uint32_t j = disks[n.index];
            const double cosine = dot(surfels.normals[i], surfels.normals[j]);
            if (j != i && cosine > above && cosine <= up_to) out.push_back(j);
        }
    };
    take(epsilon, 2.0);
    const std::size_t surface = out.size();
    take(sharpest_crease, epsilon);
    return surface;
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
    std::vector<bool> is_patch(surfels.size(), false);
    for (const Triangle& t : surfels.triangles) {
        areas[t.surfel] += area_of(t);
        is_patch[t.surfel] = true;
    }
    std::vector<std::uint32_t> disks;
    std::vector<Vec3> centers;
    std::vector<double> radii;
    for (std::uint32_t i = 0; i < surfels.size(); ++i) {
        if (is_patch[i]) continue;
        disks.push_back(i);
        centers.push_back(surfels.positions[i]);
        radii.push_back(surfels.radii[i]);
    }
    if (disks.empty()) return areas;

    const DiskIndex index(centers, radii);
    parallel_blocks(
        disks.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near;
            std::vector<std::uint32_t> members;
            std::vector<DiskTerm> flat;
            std::vector<CurvedTerm> curved;
            for (std::size_t k = begin; k < end; ++k) {
                const std::uint32_t i = disks[k];
                const Frame frame = frame_around(surfels.normals[i]);
                const std::size_t surface = sharing(surfels, index, disks, i, options.epsilon, near, members);
                const auto kappa = static_cast<float>(options.kappa);
                double share = 0.0;
                if (options.method == AreaMethod::paper) {
                    flat.clear();
                    for (std::size_t m = 0; m < surface; ++m) flat.push_back(term_of(surfels, i, frame, members[m]));
                    share = integrate_paper(flat.data(), surface, kappa, options.resolution);
                } else {
                    curved.clear();
                    for (std::uint32_t j : members) curved.push_back(curved_term_of(surfels, i, frame, j));
                    share = integrate_curved(curved.data(), surface, curved.size(), kappa, options.resolution);
                }
                areas[i] = surfels.radii[i] * surfels.radii[i] * share;
            }
        },
        progress);
    return areas;
}

}  // namespace surflux
