#pragma once

#include <vector>

#include "surflux/core/progress.h"
#include "surflux/radiosity/cut.h"
#include "surflux/radiosity/gathered_system.h"
#include "surflux/radiosity/gathering.h"

namespace surflux {

// The light that an eye at each node of a cut has grown used to: the logarithmic mean of the irradiance (its luminance)
// of what the node's rays meet, as tone mapping takes it of a picture (Reinhard and others 2002). A bright gap counts
// by its solid angle alone, and so does what is dark in a bright room. Where rays escape it is the node's own. No light
// counts as less than `least`.
std::vector<double> local_light(const SurfelTree& tree, const Gathering& gathering, const Cut& cut,
                                const GatheredSystem& system, const std::vector<double>& values, double least,
                                const Progress& progress = {});

}  // namespace surflux
