#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/span.h"
#include "surflux/scene/scene.h"

namespace surflux {

// A part of the surface, as its corners.
struct Corners {
    Vec3 a, b, c;
    Vec3 center() const { return (a + b + c) / 3.0; }
};

// Of the three edges, its square.
inline double longest_edge_squared(const Corners& t) {
    return std::max({length_squared(t.b - t.a), length_squared(t.c - t.b), length_squared(t.a - t.c)});
}

// The halves on both sides of the middle of the longest edge: slivers, too, come into pieces about as long as wide.
inline void bisect(const Corners& t, Corners& first, Corners& second) {
    const double ab = length_squared(t.b - t.a), bc = length_squared(t.c - t.b), ca = length_squared(t.a - t.c);
    const Corners turned = ab >= bc && ab >= ca ? t : bc >= ca ? Corners{t.b, t.c, t.a} : Corners{t.c, t.a, t.b};
    const Vec3 middle = 0.5 * (turned.a + turned.b);
    first = {turned.c, turned.a, middle};
    second = {turned.b, turned.c, middle};
}

// The surfaces of a scene in pieces, object by object: the triangles of patches, and disks. Pieces have numbers: of the
// triangles first, then of the disks.
class SurfacePieces {
public:
    explicit SurfacePieces(const Scene& scene);

    std::size_t objects() const { return begin_.size() - 1; }
    // Those of an object that have an area.
    Span<std::uint32_t> of_object(std::size_t object) const {
        return {order_.data() + begin_[object], order_.data() + begin_[object + 1]};
    }
    double area_of(std::size_t object) const { return area_[object]; }

    bool is_disk(std::uint32_t piece) const { return piece >= triangles_; }
    std::uint32_t surfel_of(std::uint32_t piece) const;
    // Of a disk its centre, three times.
    Corners corners(std::uint32_t piece) const;
    double area(std::uint32_t piece) const;

private:
    const Scene& scene_;
    std::uint32_t triangles_ = 0;
    std::vector<std::uint32_t> disks_, end_begin_, order_;
    std::vector<std::size_t> begin_;
    std::vector<double> area_;
};

// The part of a piece after repeated bisect(), a node of its binary tree. `path` is the node's index, as in a heap: a
// leading 1, then a bit for each bisection from the first on, 1 for the second half. The nodes above the last one are
// kept. Two paths cut to the same length share the bits above the leading one of their XOR: so many bisections are not
// made anew.
class PartFinder {
public:
    explicit PartFinder(const SurfacePieces& pieces) : pieces_(pieces) {}
    const Corners& corners(std::uint32_t piece, std::uint32_t path);

private:
    const SurfacePieces& pieces_;
    std::uint32_t piece_ = 0, path_ = 0;
    Corners after_[32];  // so many bisections
};

}  // namespace surflux
