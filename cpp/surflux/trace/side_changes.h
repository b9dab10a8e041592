#pragma once

#include "surflux/scene/surfels.h"
#include "surflux/trace/sheet_sides.h"

namespace surflux {

// Marks as unsure what stands on lines along which normals change sides, in tangled sheets, once what is turned is
// turned over: to one side of such a surfel its sheet goes on, to the other it goes on and faces the other way.
void find_side_changes(const Surfels& surfels, SheetSides& sides);

}  // namespace surflux
