#pragma once

#include <vector>

#include "surflux/core/progress.h"
#include "surflux/meshless/basis_sight.h"
#include "surflux/meshless/multilevel_basis.h"
#include "surflux/meshless/tuning.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Half spaces that clip supports of the finest level at walls, against light leaks, which L07 names as its limit and
// leaves to finer levels. Some closest-hit rays parallel to the surface propose planes, of the surfels that they meet;
// one clips a support if, of the functions that reach its point, those beyond the plane are all unjoined (BasisSight):
// a column, around which light gets, does not. A function has few planes at most. The field then is discontinuous on
// the plane, which the wall hides, and nowhere else.
std::vector<SupportCut> wall_cuts(const Scene& scene, const Tracer& tracer, const MultilevelBasis& basis,
                                  const BasisSight& sight, const MeshlessTuning& tuning, const Progress& progress);

}  // namespace surflux
