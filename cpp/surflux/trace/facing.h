#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/surfels.h"
#include "surflux/trace/sheet_sides.h"

namespace surflux {

struct FacingOptions {
    SheetOptions sheets;
    std::size_t most = 60'000;  // points that are looked at, drawn at random; the others follow those beside them
};

// Which points face the side of their sheet from which it is not seen, and what the sheets are.
struct Facing {
    std::vector<std::uint32_t> sheet;   // per point: index into sheets, or SheetSides::none
    std::vector<char> turned;           // per point: in a patch of at least `smallest` of those looked at
    std::vector<OrientedSheet> sheets;  // sizes are those of all points
};

Facing facing_of(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, const FacingOptions& options,
                 const Progress& progress = {});

}  // namespace surflux
