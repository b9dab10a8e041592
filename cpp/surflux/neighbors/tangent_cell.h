#pragma once

#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// What of a point's tangent plane is nearer to the point than to its neighbours in space: its Voronoi cell, cut by the
// plane (Boissonnat and Ghosh 2010, tangential Delaunay complexes; so a neighbour on another sheet, above or below,
// hardly counts). It is a plane Voronoi cell too, that of the neighbours turned down onto the plane about the lines
// where the bisectors meet it.
class TangentCell {
public:
    // Starts as an octagon, `limit` from its middle to its corners, that neighbours then cut.
    void start(const Vec3& center, const Vec3& normal, double limit);
    // Neighbours can come in any order, nearest first is fastest. One straight above the centre cuts nothing.
    void cut(const Vec3& neighbor) { cut(neighbor, false); }
    // By the line half way to `image`, behind which a crease hides what the disk has to reach, and no disk comes to
    // meet it: `image` is the centre's own, mirrored.
    void cut_at_crease(const Vec3& image) { cut(image, true); }
    // By the line half way to what is no more of the centre's surface, which ends before it: corners there are open.
    void cut_open(const Vec3& place) { cut(place, false, true); }
    // To the farthest corner, open ones included: no neighbour more than twice as far away can cut any more (Levy and
    // Bonneel 2012, radius of security).
    double farthest() const { return farthest_; }
    // The least radius with which disks around this point and its neighbours in the cell cover every Delaunay triangle
    // that it has with two of them, each the part that is nearest to it. Where no two neighbours enclose a corner, half
    // the way to the neighbour; 0 without neighbours. A corner farther away than `border` is beyond a border, and two
    // neighbours that enclose it are on other sheets, or far along this one's border.
    double covering_radius(double border) const;

private:
    struct Corner {
        double x, y;
        double nx, ny;  // the neighbour, turned down, whose bisector the side from here on belongs to; 0, 0: none's
        bool crease;
    };
    void cut(const Vec3& neighbor, bool crease, bool open = false);

    Vec3 center_;
    Frame frame_;
    double farthest_ = 0.0;
    std::vector<Corner> corners_, cut_;
};

}  // namespace surflux
