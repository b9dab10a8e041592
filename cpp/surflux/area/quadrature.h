#pragma once

#include <cstddef>

namespace surflux {

// Disk j as disk i sees it, in the coordinates (s, t) of disk i's plane, -1 to 1 across the disk. With y_j the point of
// disk j's plane over (s, t) along n_i, (r_j(y_j) / R_j)^2 = c00 + c10 s + c01 t + c20 s^2 + c11 s t + c02 t^2.
struct DiskTerm {
    float c00, c10, c01, c20, c11, c02;
    float stretch;  // dA_j / dA_i = 1 / (n_i . n_j), D04 eq. 8
};

// D04 eq. 9 over disk i, whose own term stands first, in units of R_i^2:
// the integral of w_i (sum_j w_j stretch_j) / (sum_j w_j)^2 over the pixel centres of a resolution^2 grid.
// Uses AVX2 or AVX-512 where the processor has it.
double integrate_paper(const DiskTerm* terms, std::size_t count, float kappa, int resolution);

// Neighbour j in disk i's frame (u, v, n_i), in units of R_i: position, unit normal, 1 / R_j.
struct CurvedTerm {
    float x, y, z;
    float normal_x, normal_y, normal_z;
    float inverse_radius;
};

// The second-order method (see effective_area.h) over disk i, whose own term stands first, in units of R_i^2. The first
// `surface` terms predict the surface and share it; those after them, around a crease, only share it.
double integrate_curved(const CurvedTerm* terms, std::size_t surface, std::size_t count, float kappa, int resolution);

constexpr int max_resolution = 512;

// "x86-64-v2", "avx2" or "avx512": what the kernels run with on this machine.
const char* instruction_set();

}  // namespace surflux
