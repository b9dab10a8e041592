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

}  // namespace surflux
