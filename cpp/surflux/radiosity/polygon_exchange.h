#pragma once

#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// A convex planar polygon, counter-clockwise as seen from where its normal points.
using Polygon = std::vector<Vec3>;

// The part of `polygon` in front of the plane through `point`, appended to `out`, which is cleared.
void clip_to_front(const Polygon& polygon, const Vec3& point, const Vec3& normal, Polygon& out);

// Where the points of a quadrature lie on an edge: spread, or drawn to its ends, where edges that touch have their
// logarithm, and to where else another edge begins, ends or passes close by.
enum class Grading { plain, graded, steep };

// A_a F_ab of two polygons that see each other whole (see clip_to_front), by the contour integral
// 1 / (2 pi) sum over edges of a and b of the integral of ln r dx_a . dx_b (Sparrow 1963): the inner one in closed
// form, the outer one by Gauss and Legendre with `count` points, at most 32. Precise for polygons that touch, along an
// edge, a part of one, or in a corner, as for others.
double polygon_exchange(const Polygon& a, const Polygon& b, int count, Grading grading = Grading::graded);

}  // namespace surflux
