#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/scene/surfels.h"

namespace surflux {

// How the surface around a surfel bends: over the point at x along `direction` and y along normal x direction of its
// tangent plane it stands at (along x^2 + across y^2) / 2.
struct Bend {
    Vec3 direction;  // unit, in the tangent plane
    double along = 0.0, across = 0.0;
    bool sharp = false;  // does a neighbour's normal differ so much that an edge may lie between?
};

// Of the surfels asked for, fitted to the normals of their nearest neighbours of the same object: a second-order
// surface whose normal at x is n - H x. Where normals do not follow one, as at creases and in noise, the bend is less
// by the share that it leaves unexplained. No rim turns by more than 35 degrees. Neighbours are looked for among those
// `around`.
std::vector<Bend> bends_of(const Surfels& surfels, const std::vector<std::int32_t>& objects,
                           const std::vector<std::uint32_t>& asked, const std::vector<std::uint32_t>& around);

}  // namespace surflux
