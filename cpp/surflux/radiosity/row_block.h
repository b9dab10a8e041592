#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/lights/sample_points.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Rows of the transport operator as rays found them, before any weight: which surfels' fronts (NearestDisks) the
// cosine-distributed rays of each place met. Plain data: a row is the same wherever and beside whichever others it is
// made.
struct RowBlock {
    std::vector<std::size_t> begin{0};  // of each row in `met`, and the end of the last
    std::vector<std::uint32_t> met;     // surfels, ascending in each row, once for each ray
    std::vector<std::uint32_t> rays;    // that each row shot
    std::vector<std::uint32_t> into_backs;

    std::size_t size() const { return rays.size(); }
    std::size_t escaped(std::size_t row) const { return rays[row] - into_backs[row] - (begin[row + 1] - begin[row]); }
};

// One row for each place, of as many rays as `counts` has; evenest by powers of 2. Pure in (scene, place, seed).
RowBlock gather_rows(const Scene& scene, const Tracer& tracer, const std::vector<Place>& places,
                     const std::vector<int>& counts, std::uint64_t seed, const Progress& progress = {},
                     const Team& team = {});

}  // namespace surflux
