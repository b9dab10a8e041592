#pragma once

#include <cstdint>
#include <vector>

#include "surflux/lights/sample_points.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// One row of the transport operator as rays find it, before any weight: cosine-distributed rays from all of a place,
// evenest by powers of 2, and what each of them meets first. Solvers and operators make their rows of it.
struct HemisphereRow {
    std::vector<Ray> rays;
    std::vector<Hit> hits;  // of each ray
};

// Pure in (scene, place, seed): the same wherever and beside whichever others it is made. `out` is overwritten.
void gather_row(const SurfelPoints& points, const Tracer& tracer, const Place& place, int count, std::uint64_t seed,
                HemisphereRow& out);

}  // namespace surflux
