#pragma once

#include <memory>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/neighbors/orientation.h"
#include "surflux/scene/surfels.h"
#include "surflux/trace/side_rays.h"

namespace surflux {

// Takes out links between bodies and what they touch, as of a ball that rests on a floor: through the contact, links
// say that the floor goes on inside of the ball, while rays from the floor meet the ball from outside. Surfels grow to
// pieces by links, those first that have the most of them for their size, so that necks come last. A tie of two large
// pieces is a contact where it has fewer links than a border of their size, or more rays say the opposite; it is cut
// where one of the pieces closes around something. Returns the rays' scenes.
std::unique_ptr<SideRays> part_contacts(const Surfels& surfels, const std::vector<double>& spacing, std::uint64_t seed,
                                        NeighborGraph& graph, const Progress& progress = {});

}  // namespace surflux
