#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/meshless/point_grid.h"
#include "surflux/meshless/point_placement.h"

namespace surflux {

// Stratified dart throwing: parts of the surface are bisected until at most one dart (a point that may be accepted) is
// expected on each, which is thrown with that probability. disk_fill.h throws darts in batches of ever higher density,
// its windows; this is one of them.

// The surface to sample, and the options.
struct Fill {
    const Scene& scene;
    const Tracer& tracer;
    const SurfacePieces& pieces;
    std::size_t object;
    double radius;
    int rejections;
    std::uint64_t seed;  // of this object and level
    const Wanted& wanted;
};

// A cell of the surface that exclusion disks do not cover yet: a piece's part after some bisections (PartFinder), 31 at
// most, as the path's leading 1 takes one of 32 bits. Path 0 is a disk, which stands for its centre: there alone it is
// known to touch the surface, and rays that leave elsewhere may start below the next disk.
struct Part {
    std::uint32_t piece, path;
};

struct Proposal {
    Vec3 position;
    std::uint64_t priority;  // drawn at random; the lowest of those in conflict is accepted first
    std::uint32_t surfel;
    std::uint32_t part;  // its index among those that stay
};

// The exclusion disk around an accepted point.
struct KeptDisk {
    Vec3 center;
    double radius;
    bool holds(const Vec3& p) const { return length_squared(p - center) < radius * radius; }
};

struct Proposed {
    std::vector<Part> parts;  // that stay: what disks cover is left out
    std::vector<Proposal> proposals;
};

// Throws darts on the parts, `density` to a unit of area, and keeps those that are `wanted` and outside of the disks of
// points in `grid`; drops the parts that a single disk covers. In the first window it first cuts the parts into such as
// are no longer than 1.4 R.
Proposed propose(const Fill& fill, const PointGrid& grid, const Part* begin, const Part* end, double density,
                 std::uint64_t seed, bool first);

}  // namespace surflux
