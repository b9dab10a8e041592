#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/meshless/hemisphere_gather.h"
#include "surflux/meshless/meshless_field.h"
#include "surflux/scene/scene.h"

namespace surflux {

// Light on all of some surfels, gathered there: all but what lights bring to them and what is aimed. A surfel has as
// many rays as it is long, `most_rays` at most. `spacing`: of points on the coarsest level, by object. What is bounced:
// `gain` times what the basis sends with `coefficients`, and what lights and emitters bring to where rays end.
std::vector<MeshlessField::At> gather_on_surfels(const Scene& scene, HemisphereGather& gather,
                                                 const std::vector<std::uint32_t>& surfels,
                                                 const std::vector<double>& spacing, int most_rays,
                                                 const std::vector<Rgb>& coefficients, double gain,
                                                 const Progress& progress);

}  // namespace surflux
