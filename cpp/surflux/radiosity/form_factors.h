#pragma once

#include <cstdint>

#include "surflux/core/progress.h"
#include "surflux/lights/hemisphere.h"
#include "surflux/scene/scene.h"

namespace surflux {

struct FormFactorOptions {
    bool visibility = true;  // off: every pair sees each other, and nothing is closed
    int rays = 1024;         // per surfel, to measure what escapes
    double epsilon = 0.8;    // same surface where n_i . n_j is above this, D04 eq. 10
    std::uint64_t seed = 0;
};

// F_ij of all pairs into n x n doubles at `out`, row-major. Gives what each row leaves to make 1, after closure; empty
// without visibility. The scene needs areas.
Hemispheres form_factors(const Scene& scene, const FormFactorOptions& options, double* out,
                         const StageProgress& progress);

}  // namespace surflux
