#pragma once

#include <cstddef>
#include <cstdint>

#include "surflux/core/progress.h"
#include "surflux/lights/direct.h"
#include "surflux/scene/scene.h"
#include "surflux/solution/solution.h"
#include "surflux/trace/tracer.h"

namespace surflux {

struct InsertionAfterOptions {
    double zeta = 0.02;           // difference that interpolation may leave, of the RMS of H
    std::size_t max_surfels = 0;  // 0: as leaves_allowed() says
    DirectOptions direct;
    std::uint64_t seed = 0;
};

// Inserts surfels into a solution on the scene's own, where its field asks for them (D04 7.2). What comes to them from
// lights is computed, all else interpolated.
void insert_after(const Scene& scene, const Tracer& tracer, const InsertionAfterOptions& options,
                  const Progress& progress, Solution& solution);

}  // namespace surflux
