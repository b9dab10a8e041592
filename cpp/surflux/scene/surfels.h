#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// A triangle of the patch that surfel `surfel` stands for (D04 7.3), counter-clockwise seen from the surfel's front.
struct Triangle {
    Vec3 a, b, c;
    std::uint32_t surfel = 0;
};

inline Vec3 cross_of(const Triangle& t) { return cross(t.b - t.a, t.c - t.a); }
inline double area_of(const Triangle& t) { return 0.5 * length(cross_of(t)); }

// Surfels as a structure of arrays (D04 section 4); all arrays have the same length, but areas may be empty.
// Positions stay in float64 in the user's frame; a pass that works in float32 recentres them at its border.
struct Surfels {
    std::vector<Vec3> positions;
    std::vector<Vec3> normals;     // unit
    std::vector<double> radii;     // of the tangent disks, R
    std::vector<double> areas;     // effective areas, S; empty until somebody computes them
    std::vector<Rgb> reflectance;  // rho, linear, 0 <= rho < 1
    std::vector<Rgb> emission;     // E, exitance
    // Patches of a mesh, sorted by surfel. A surfel with triangles occludes by them, not by its disk.
    std::vector<Triangle> triangles;

    std::size_t size() const { return positions.size(); }
};

// Where the triangles of each surfel stand: those of surfel i are [begin[i], begin[i + 1]) of `triangles`.
std::vector<std::uint32_t> triangle_ranges(const Surfels& surfels);

// The surfels at `indices`, in that order, with their triangles.
Surfels select(const Surfels& surfels, const std::vector<std::uint32_t>& indices);

// The surfels followed by a copy of each that faces the other way: a sheet seen from both sides.
Surfels two_sided(const Surfels& surfels);

struct Box {
    Vec3 low, high;
    Vec3 center() const { return 0.5 * (low + high); }
    double diagonal() const { return length(high - low); }
};

// Of the positions and, where there are any, the triangles.
Box bounds_of(const Surfels& surfels);

// Surfaces no farther apart than this touch: the float coordinates in which rays are traced cannot tell them apart.
double contact_distance(const Box& box);

}  // namespace surflux
