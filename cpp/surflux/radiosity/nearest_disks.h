#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/radiosity/tuning.h"
#include "surflux/scene/scene.h"

namespace surflux {

// Which of overlapping disks a place belongs to: the one with the nearest centre, whichever a ray met first; of those
// at one place any, by chance. So each has about its effective area of what is met, and where one sticks out through a
// thin wall, the wall's side is met.
class NearestDisks {
public:
    explicit NearestDisks(const Scene& scene, const Progress& progress = {}, const RefinementTuning& tuning = {});

    // Of what was met at a place.
    std::uint32_t owner(std::uint32_t surfel, const Vec3& at) const;

private:
    std::uint32_t one_of_its_place(std::uint32_t surfel, const Vec3& at) const;

    const Scene& scene_;
    std::size_t each_;
    double own_cell_;
    std::vector<std::uint32_t> beside_;  // some of each surfel, if it is a disk, its nearest others; or itself
};

}  // namespace surflux
