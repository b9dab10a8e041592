#pragma once

#include <vector>

#include "surflux/scene/surfels.h"

namespace surflux {

// Convex pieces of a patch, whose corners are given from some origin near it: far from that of the scene, differences
// keep their digits.
using Polygon = std::vector<Vec3>;
using Pieces = std::vector<Polygon>;

// The triangles from `begin` to `end`.
Pieces pieces_of(const Triangle* begin, const Triangle* end, const Vec3& origin);

double area_of(const Pieces& pieces);

// What of the pieces the triangle does not cover: where its plane lies from `low` to `high` above them, along its
// normal.
Pieces without(const Pieces& pieces, const Triangle& t, const Vec3& origin, double low, double high);

}  // namespace surflux
