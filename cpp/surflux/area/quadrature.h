#pragma once

#include <cstddef>
#include <cstdint>

#include "surflux/area/polar_grid.h"

namespace surflux {

// Disk j as disk i sees it, in the coordinates (s, t) of disk i's plane, -1 to 1 across the disk. With y_j the point of
// disk j's plane over (s, t) along n_i, (r_j(y_j) / R_j)^2 = c00 + c10 s + c01 t + c20 s^2 + c11 s t + c02 t^2.
struct DiskTerm {
    float c00, c10, c01, c20, c11, c02;
    float stretch;  // dA_j / dA_i = 1 / (n_i . n_j), D04 eq. 8
};

// SIMD kernels. D04 eq. 9 over disk i, whose own term stands first, in units of R_i^2: the integral of w_i (sum_j w_j
// stretch_j) / (sum_j w_j)^2 over the pixel centres of a resolution^2 grid. Uses AVX2 or AVX-512 where the processor
// has it.
double integrate_paper(const DiskTerm* terms, std::size_t count, float kappa, int resolution);

// One that shares disk i, in its frame and in units of R_i: its place on the modelled surface and 1 / R_j^2.
struct Sharer {
    float x, y, z, inverse_square_radius;
};

// The model of the surface (surface_fit.h) in single precision.
struct CurvedSurface {
    float kxx, kxy, kyy, gx, gy, z0;
};

// Where a sharer ends: it has a part in points with x X + y Y + z Z <= limit alone.
struct SharerEnd {
    std::uint32_t sharer;
    float x, y, z, limit;
};

// The second-order method (see effective_area.h) over disk i, in units of R_i^2: the integral of
// w_i / (sum_j w_j) / n_z over the points of `grid`, whose direction d ends at `ends[d]`. The first of `count` sharers
// is i itself. `sharer_ends` are in the order of the sharers.
double integrate_curved(const CurvedSurface& surface, const Sharer* sharers, std::size_t count, const float* ends,
                        float kappa, const PolarGrid& grid, const SharerEnd* sharer_ends = nullptr,
                        std::size_t sharer_end_count = 0);

// "x86-64-v2", "avx2" or "avx512": what the kernels run with on this machine.
const char* instruction_set();

}  // namespace surflux
