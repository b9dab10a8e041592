#pragma once

#include "surflux/core/vec.h"

namespace surflux {

// The direction that a point of the unit square stands for: evenly over the solid angle of a triangle with corners in
// unit directions a, b and c (Arvo 1995).
Vec3 square_to_spherical_triangle(const Vec3& a, const Vec3& b, const Vec3& c, double s, double t);

}  // namespace surflux
