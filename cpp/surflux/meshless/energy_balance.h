#pragma once

#include <vector>

#include "surflux/meshless/meshless_field.h"
#include "surflux/meshless/surface_light.h"

namespace surflux {

// What surfels reflect of the light that the basis says they have, less what leaves the scene or meets backs, over what
// of it arrives: Shepard's weights do not carry on what rises towards an edge, and so lose a little. `bounced`: the
// coefficients of what arrives. `lost`: those of the share of the hemisphere that does not end on fronts. `even`: of
// each surfel, over how much of it the field is about even. Surfels that are `inside` geometry have no part in it.
double energy_correction(const Scene& scene, const SurfaceLight& light, const MeshlessField& field,
                         const std::vector<Rgb>& bounced, const std::vector<Rgb>& lost, const std::vector<double>& even,
                         const std::vector<char>& inside, bool indirect_only);

}  // namespace surflux
