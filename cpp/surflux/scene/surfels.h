#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"
#include "surflux/scene/colors.h"
#include "surflux/scene/gloss.h"

namespace surflux {

// A triangle of the patch that surfel `surfel` stands for (D04 7.3), counter-clockwise seen from the surfel's front.
struct Triangle {
    Vec3 a, b, c;
    std::uint32_t surfel = 0;
};

// Where the surface of a disk ends before its rim: dot(normal, p - position) <= limit. Beyond a crease there is
// nothing, for the surface goes on elsewhere; nor is there beyond a border of the sampling, unless that runs into
// another object, which it then adjoins: pieces that adjoin let no light through.
struct DiskEnd {
    enum Kind : std::uint32_t { crease, border };
    Vec3 normal;  // unit, in the plane of the disk
    double limit = 0.0;
    std::uint32_t surfel = 0;
    Kind kind = crease;
};

inline Vec3 cross_of(const Triangle& t) { return cross(t.b - t.a, t.c - t.a); }
inline double area_of(const Triangle& t) { return 0.5 * length(cross_of(t)); }

// Surfels as a structure of arrays (D04 section 4); all arrays have the same length, but areas may be empty.
// Positions stay in float64 in the user's frame; a pass that works in float32 recentres them at its border.
struct Surfels {
    std::vector<Vec3> positions;
    std::vector<Vec3> normals;  // unit
    std::vector<double> radii;  // of the tangent disks, R
    std::vector<double> areas;  // effective areas, S; empty until somebody computes them
    Colors reflectance;         // rho, linear, 0 <= rho < 1
    Colors emission;            // E, exitance
    Gloss gloss;                // beside rho; the path tracer and transfer of distant light know it, no solver
    // Patches of a mesh, sorted by surfel. A surfel with triangles occludes by them, not by its disk.
    std::vector<Triangle> triangles;
    // Of disks, sorted by surfel: most have none.
    std::vector<DiskEnd> ends;
    // Disks that no other one continues, ascending: light comes to all of the disk of their area, and not only to the
    // centre, where alone a disk touches a curved surface.
    std::vector<std::uint32_t> alone;

    std::size_t size() const { return positions.size(); }
};

// Where the triangles of each surfel stand: those of surfel i are [begin[i], begin[i + 1]) of `triangles`.
std::vector<std::uint32_t> triangle_ranges(const Surfels& surfels);

// The same of `ends`.
std::vector<std::uint32_t> end_ranges(const Surfels& surfels);

// The surfels at `indices`, in that order, with their triangles and ends.
Surfels select(const Surfels& surfels, const std::vector<std::uint32_t>& indices, const Progress& progress = {});

// The surfels followed by a copy of each that faces the other way: a sheet seen from both sides.
Surfels two_sided(const Surfels& surfels);

// Is each the same in all three channels?
bool is_grey(const std::vector<Rgb>& values);
bool is_grey(const Colors& values);

struct Box {
    Vec3 low, high;
};

// Of the positions and, where there are any, the triangles.
Box bounds_of(const Surfels& surfels);

}  // namespace surflux
