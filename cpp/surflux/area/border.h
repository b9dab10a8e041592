#pragma once

#include <vector>

namespace surflux {

struct Point2 {
    double x, y;
};

// The points (X, Y) with x X + y Y <= limit, (x, y) of unit length.
struct HalfPlane {
    double x, y, limit;
};

// The sides of the convex hull of `points` as half planes that hold them all; none where they lie on a line.
// Reorders the points.
void hull_sides(std::vector<Point2>& points, std::vector<HalfPlane>& sides);

// Leaves out sides that only bevel a corner: beyond which their neighbours meet within `tolerance`. `sides` go around a
// convex polygon; at least three remain.
void sharpen_corners(std::vector<HalfPlane>& sides, double tolerance);

}  // namespace surflux
