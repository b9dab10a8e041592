#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/neighbors/disk_kernel.h"
#include "surflux/scene/surfels.h"

namespace surflux {

enum class AreaMethod { paper, curved };

// Where the quadrature runs; the neighbourhoods are found on the CPU either way. `automatic` is the faster one by what
// the machine is: OpenGL where a GPU draws and the quadrature alone would take the CPU more than half a second; no
// context is made to find that out for less. Software renderers are some four times slower than the CPU's own kernels.
enum class AreaBackend { automatic, cpu, gl };

struct AreaOptions {
    AreaMethod method = AreaMethod::curved;
    double kappa =
        sharing_power;     // how fast a surfel's influence falls with distance (paper: exp(-kappa r / R), D04 eq. 6)
    int resolution = 32;   // pixels across a disk, n_x = n_y of D04 5.3
    double epsilon = 0.8;  // neighbours on the same surface have n_i . n_j above this, D04 eq. 10
    AreaBackend backend = AreaBackend::automatic;
};

// Throws ArgumentError for a value out of range.
void check(const AreaOptions& options);

// Which surfels are disks, and not patches of a mesh.
std::vector<bool> disks_among(const Surfels& surfels);

// Of patches, by their triangles; 0 of disks.
std::vector<double> patch_areas(const Surfels& surfels);

// Effective areas by quadrature over each tangent disk. Surfels with triangles have the exact area of their patch and
// take no part in the others' disks.
//
// paper: D04 eq. 4-9 (the area factor enters once, as in D03 eq. 9). All tangent planes lie outside a convex surface,
// so that areas come out too large by O((R / r)^2).
//
// curved: second order. The surface over disk i is a model fitted to the surfels around (surface_fit.h), exact on
// spheres. Weights are taken not on the disks but at the model's point p over each point of the disk, and its element
// is stretched by 1 / (n_i . n), n the model's normal there. The weight is |p - x_j|^(-2 kappa) (1 - |p - x_j|^2 /
// R_j^2): it depends on distance alone, not on distance over R_j, so that a piece of surface goes to the nearest surfel
// however the radii vary (for large kappa the areas are those of Voronoi cells), and it ends at the disk's rim without
// a step. The disk ends at creases and at borders of the sampling (neighborhood.h), where D04 lets it overhang.
// No area is more than that of its disk, which is all that blocks light: loose leaves have no neighbours to share what
// their wider domains hold.
std::vector<double> effective_areas(const Surfels& surfels, const AreaOptions& options, const Progress& progress = {});

}  // namespace surflux
