#pragma once

#include <vector>

#include "surflux/core/vec.h"
#include "surflux/scene/surfels.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// In radii of a surfel: how far behind it rounding puts points, and a curve does that patches are chords of (as far as
// Tracer::departure looks for disks).
inline constexpr double by_rounding = 1e-3, by_curves = 0.5;

// Points of surfaces, of which some lie behind theirs: those are moved along their normals up to it. Rays from there
// would begin within the body. A point is behind what its normal meets from behind, no farther than `farthest` radii of
// that surfel, unless it belongs to another (Tracer::departure), or something that faces its way is nearer below it.
// Behind a sheet of two sides is air: through one, points move no farther than rounding of floats puts them.
std::vector<Vec3> onto_surface(const Surfels& surfels, const Tracer& tracer, const std::vector<Vec3>& points,
                               const std::vector<Vec3>& normals, double farthest = by_curves);

}  // namespace surflux
