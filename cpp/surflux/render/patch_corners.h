#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"
#include "surflux/transfer/sparse_rows.h"

namespace surflux {

// Light at the corners of patches, to be interpolated over their triangles: at each corner a mean of the patches that
// adjoin there and make one surface with the patch, the nearer the more. So pictures show no facets, and nothing
// bleeds over edges, nor beneath walls (Sight).
struct PatchCorners {
    std::vector<std::uint32_t> of_triangle;  // 3 for each: rows of `means`
    SparseRows means;                        // over surfels; each row makes 1
};

// `areas`: of each surfel what light comes to, which is less than all of it where it goes on inside of geometry: what
// is buried has no say.
PatchCorners patch_corners(const Scene& scene, const Tracer& tracer, const std::vector<double>& areas,
                           const Progress& progress = {});

}  // namespace surflux
