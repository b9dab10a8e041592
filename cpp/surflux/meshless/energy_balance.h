#pragma once

#include <vector>

#include "surflux/meshless/surface_light.h"
#include "surflux/meshless/surfel_means.h"

namespace surflux {

// What surfels reflect of the light that the basis says they have, less what leaves the scene or meets backs, over what
// of it arrives: Shepard's weights do not carry on what rises towards an edge, and so lose a little. `bounced`: the
// coefficients of what arrives. `lost`: those of the share of the hemisphere that does not end on fronts.
double energy_correction(const Scene& scene, const SurfaceLight& light, const SurfelMeans& means,
                         const std::vector<Rgb>& coefficients, const std::vector<Rgb>& bounced,
                         const std::vector<Rgb>& lost, bool indirect_only);

}  // namespace surflux
