#pragma once

#include <cstdint>
#include <vector>

#include "surflux/scene/surfels.h"

namespace surflux {

// Regions of the surface, of about equal area, alike in place and normal.
struct Regions {
    Regions(const Surfels& surfels, std::size_t wanted);
    std::vector<std::uint32_t> of;  // each surfel's
    std::size_t count = 0;
};

// The irradiance that one half of the rays of a place gathers when surfaces send what a solution says, and how much of
// it depends on what: by region, what reaches the place per unit of irradiance there.
struct Gathered {
    explicit Gathered(std::size_t regions) : from(regions) {}
    Rgb irradiance;
    std::vector<Rgb> from;
};

// A surfel of a solution, and what the two independent halves of its rays gathered, as sums.
struct Residual {
    Rgb irradiance;
    std::uint32_t region;
    const Gathered* halves[2];
};

struct ErrorEstimate {
    double error = 0.0;        // relative RMS; never less than what its rays can tell
    double uncertainty = 0.0;  // standard error of `error`
};

// The error e of H at surfels solves e = r + T e, with r the residual D + T H - H and T one bounce. Of T e only the
// mean over each region is resolved: a coarse system, solved for each half of the rays, brings all bounces (defect
// correction on a coarse grid; Brandt 1977). The estimate is sqrt(sum e'.e'' / sum (H + e').(H + e'')) of the two
// halves: the noise of their rays has no part in its mean.
ErrorEstimate error_from(const std::vector<Residual>& residuals, std::size_t regions, double rays_each);

}  // namespace surflux
