#pragma once

#include <vector>

#include "surflux/scene/surfels.h"

namespace surflux {

// Polygon clipping: set differences of a patch, as convex polygons, and triangles. Corners are given from some origin
// near the patch: far from that of the scene, differences keep their digits.
using Polygon = std::vector<Vec3>;
using Pieces = std::vector<Polygon>;

// The triangles from `begin` to `end`.
Pieces pieces_of(const Triangle* begin, const Triangle* end, const Vec3& origin);

double area_of(const Pieces& pieces);

// What of the pieces the triangle does not cover: where its plane lies from `low` to `high` above them, along its
// normal.
Pieces without(const Pieces& pieces, const Triangle& t, const Vec3& origin, double low, double high);

// The same for many triangles, one after the other: adds what triangle t takes to taken[t.surfel], and gives the area
// that none of them covers. Halves space, so that the work is n log n for n small triangles side by side over a large
// patch.
double take_in_turn(const Pieces& pieces, const std::vector<Triangle>& triangles, const Vec3& origin, double low,
                    double high, std::vector<double>& taken);

}  // namespace surflux
