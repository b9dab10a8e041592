#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/surfels.h"
#include "surflux/trace/sheet_sides.h"

namespace surflux {

struct FacingOptions {
    SheetOptions sheets;
    std::size_t most = 60'000;  // places that are looked at, drawn at random; the other points follow those beside them
};

// Which points face the side of their sheet from which it is not seen, and what the sheets are. Points at one place
// that face away from each other are two sides of a sheet, and right.
struct Facing {
    std::vector<std::uint32_t> sheet;   // per point: index into sheets, or SheetSides::none
    std::vector<char> turned;           // per point: in a patch of at least `smallest` of those looked at
    std::vector<char> unsure;           // per point: where normals change sides, and nothing tells which are right
    std::vector<OrientedSheet> sheets;  // sizes are those of all points
};

Facing facing_of(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, const FacingOptions& options,
                 const Progress& progress = {});

}  // namespace surflux
