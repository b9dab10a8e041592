#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/radiosity/tuning.h"
#include "surflux/trace/compiled_scene.h"

namespace surflux {

struct FormFactorOptions {
    bool visibility = true;  // off: every pair sees each other, and nothing is closed
    double error = 0.001;    // of what a surfel sends to any set of others, with 95 % probability (visible_share.h)
    int rays = 1024;         // per surfel, to measure what escapes
    double epsilon = 0.8;    // same surface where n_i . n_j is above this, D04 eq. 10
    std::uint64_t seed = 0;
    FormFactorTuning tuning = {};
};

struct FormFactors {
    std::vector<double> rest;   // 1 minus each row's sum: what escapes or meets backs; empty without visibility
    std::size_t imprecise = 0;  // pairs that the most rays a pair gets did not bring to the error
    std::size_t rays = 0;
};

// F_ij of all pairs into n x n doubles at `out`, row-major. The scene needs areas.
// Rows are closed as `solve` does it (closure.h), only more precisely.
FormFactors form_factors(const CompiledScene& compiled, const FormFactorOptions& options, double* out,
                         const StageProgress& progress);

}  // namespace surflux
