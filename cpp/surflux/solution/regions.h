#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/surfels.h"
#include "surflux/solution/tuning.h"

namespace surflux {

// The coarse grid of error_from() (residuals.h): regions of the surface, of about equal area, alike in position and
// normal, each with one unknown, its mean error. What of one is far dimmer than the rest, as behind a wall or beneath a
// box, is a region of its own: its errors are others.
struct Regions {
    // `irradiance`: of each surfel, by the solution.
    Regions(const Surfels& surfels, const std::vector<Rgb>& irradiance, std::size_t wanted,
            const Progress& progress = {}, const SelfCheckTuning& tuning = {});
    // How many times the mean error of its region a surfel has: as many times as the irradiance there. So has light
    // that is lost, or is too much, on its way. What is hidden has no part in it: rays do not find it, and by area its
    // share would be missing from what they do find. Where nothing of a region is lit, 1.
    Rgb shape(std::size_t region, const Rgb& irradiance) const;

    std::vector<std::uint32_t> of;     // each surfel's
    std::vector<double> share;         // of all area
    std::vector<Rgb> light;            // mean size of the irradiance, by area
    std::vector<Rgb> reflectance;      // mean by area, of surfels by their shapes
    std::vector<std::uint32_t> whole;  // the region that each is a part of: itself, or the one that it is dim beside
    std::size_t count = 0;

private:
    void part_dim(const Surfels& surfels, const std::vector<Rgb>& irradiance, const SelfCheckTuning& tuning,
                  const Progress& progress);
};

}  // namespace surflux
