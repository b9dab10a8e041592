#pragma once

#include <vector>

#include "surflux/lights/spot_cone.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// The integral of cone.share over the directions from `light` to a triangle, to some 1e-9: what a spot light of
// intensity 1 brings to it, unoccluded, if it faces the light.
double spot_power(const Vec3& light, const SpotCone& cone, const Triangle& triangle);

// Appends what of the triangle a spot light may shine on, in triangles: inside the pyramid around a cone of less than
// 120 degrees, and all of it for a wider one.
void append_lit(const Vec3& light, const SpotCone& cone, const Triangle& triangle, std::vector<Triangle>& out);

}  // namespace surflux
