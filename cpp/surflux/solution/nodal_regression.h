#pragma once

#include <vector>

#include "surflux/core/progress.h"
#include "surflux/solution/nodal_field.h"
#include "surflux/solution/sight.h"
#include "surflux/solution/tuning.h"

namespace surflux {

// Values at nodes without most of the noise of their rays: each is that of a quadratic fitted to the nodes around, by
// weighted least squares in its tangent plane (local regression: Cleveland 1979). From how many, or whether at all, is
// told by Stein's unbiased estimate of the risk (1981), averaged around: what stands out of the noise stays.
// `standard_error`: of each, by its own rays alone, as color_norm(); all channels are taken to have as much of it, of
// what they are. Nodes beyond walls do not count (`sight`).
std::vector<Rgb> without_noise(const NodalField& nodes, const std::vector<Rgb>& values,
                               const std::vector<double>& standard_error, const Sight& sight,
                               const Progress& progress = {}, const RegressionTuning& tuning = {});

}  // namespace surflux
