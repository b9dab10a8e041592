#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/packing.h"
#include "surflux/solution/regions.h"

namespace surflux {

// What one half of a place's rays gathers (ResidualRays): the irradiance, and its row of the coarse operator: by
// region, what reaches the place per unit of mean error there.
struct Gathered {
    // Of lamps, as sums: what samples bring that are lit, and all of them, for which there is a closed form; and what
    // is known of each lamp by itself, where one is close (CloseLamps).
    struct Lamps {
        Rgb lit, all, unoccluded, by_themselves;
        // Ratio estimator (Cochran 1977, 6.2): only places where a lamp is partly blocked have variance.
        Rgb sum() const;
    };
    explicit Gathered(std::size_t regions) : from(regions), met(regions) {}
    Lamps lamps;
    Rgb irradiance;  // but that of lamps
    std::vector<Rgb> from;
    // Of one bounce alone, of which each surfel sends one value: rays that meet fronts, by region, and all others; T B;
    // and `irradiance`.
    std::vector<double> met;
    double lost = 0.0;
    Rgb of_surfels, of_all;

    // For other processes (core/team.h): regions alone that something was met in.
    void pack(Packed& to) const;
    void unpack(Unpacking& bytes);
};

// A surfel of a solution, and what the two independent halves of its rays gathered, as sums.
struct Residual {
    Rgb irradiance, direct, radiosity;
    std::uint32_t region;
    const Gathered* halves[2];
    Rgb reflectance;
    double weight = 1.0;  // what it stands for beside those drawn by area: 1 in the mean
};

struct ErrorEstimate {
    double error = 0.0;        // relative RMS; never less than what its rays can tell; NaN where H is 0 all over
    double uncertainty = 0.0;  // standard error of `error`
    // By local light: the median and the 90th percentile, over the surfels, of the relative RMS error of their region.
    // Regions darker than a share of the RMS of H are left out.
    double local = 0.0, local_p90 = 0.0;
    double local_floor = 0.0;  // the same 90th percentile of what rays can tell at all
};

// The error e of H at surfels solves e = r + T e, with r the residual D + T H - H and T one bounce. Of the e that T is
// applied to only the mean over each region is resolved, and within it e goes by H (Regions::shape()): a coarse system,
// solved for each half of the rays, brings all bounces (defect correction on a coarse grid; Brandt 1977). An e that is
// a share of H it has without an error of its own, whatever of a region is hidden. The estimate is sqrt(sum e'.e'' /
// sum (H + e').(H + e'')) of the two halves: they are independent, so that the variance of their rays does not bias it.
//
// Bounces amplify the mean residual, by 1 / (1 - rho) in a closed room, and with it the chance of which surfels were
// drawn and of what their rays met. Reciprocity takes out both. The coarse exchange, A_k F_kg by area, is scaled to be
// symmetric, with rows that make A_k together with what they lose. What of a region's light it carries is told by the
// rays of its places, and scaled to be all that is not lost. And what is sent arrives or is lost, sum A T B = sum
// A B (1 - l) with l the share lost of what a surfel sends: the mean of c = D + T B + l B - H over all surfels is that
// of D + B - H, `balance`, which no rays are needed for, so that c is a control variate of r. With m_k the mean of r,
// of one bounce, over the places drawn in region k, and c' of c over all by regions' areas, m_k gains (balance - c')
// cov(m_k, c') / var(c'), the regression of least variance (Cochran 1977, 7.3), whose moments come from the sample,
// within regions. Where nothing is lost c is r but for the error of D; where most is, they have little in common, and
// so little is gained.
//
// In a dim room the light of single surfels is mostly noise of the few rays here. Over a region, though, sum e'.e'' /
// sum (H + e').(H + e'') is as free of its bias as it is over all; `dimmest`: the share of the RMS of H below which a
// region is too dark to count.
ErrorEstimate error_from(const std::vector<Residual>& residuals, const Regions& regions, double rays_each,
                         const Rgb& balance, double dimmest = 1e-3);

}  // namespace surflux
