#pragma once

#include "surflux/scene/surfels.h"
#include "surflux/trace/sheet_sides.h"
#include "surflux/trace/side_rays.h"

namespace surflux {

// Closed sheets whose links contradict each other, as of a statue whose folds are thinner than its points are apart:
// links do not tell which of its surfels face the other way, but rays tell of each patch that is of one mind which side
// of it is seen. Patches that few rays leave go with what they continue. Marks such sheets as settled, sets `against`
// of their surfels.
// Sheets that seem open are closed where rays tell one side of nearly all of their patches.
void settle_by_rays(const Surfels& surfels, const SideRays& rays, const SheetOptions& options, SheetSides& sides);

}  // namespace surflux
