#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// Where surfels are and how large what they make is, by medians: a stray point or triangle, or a pile of points at one
// place, leaves both as they are. A pass that works in float32 takes `middle` off positions and divides by `unit`.
struct Extent {
    explicit Extent(const Surfels& surfels);

    Vec3 middle;                // median, by axis, of the surfels' places, each counted once
    double size = 0.0;          // twice the median of what each surfel's farthest point is from there
    double unit = 1.0;          // the power of 2 below `size`: dividing by it rounds nothing
    std::vector<double> reach;  // of each surfel: how far its farthest point is from `middle`

    // Surfaces no farther apart than this touch, at a place so far from the middle: the float coordinates in which rays
    // are traced cannot tell them apart. They are the coarser the farther out.
    double contact(double distance) const;
    double contact(const Vec3& place) const { return contact(length(place - middle)); }
    double contact_of(std::uint32_t surfel) const { return contact(reach[surfel]); }
};

}  // namespace surflux
