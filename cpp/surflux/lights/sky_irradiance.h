#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/lights/sample_points.h"
#include "surflux/lights/sky_cells.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// What arrives at a place from the images of Environments.
struct SkyLight {
    Rgb irradiance;
    double error = 0.0;  // estimated standard error of the luminance, 0 where all rays agree
    // Of the luminance, without narrow bright spots: what arrives, and what surfaces keep off.
    double arrived = 0.0, hidden = 0.0;
};

// On the shapes of `points`: what each cell of the sky brings to the place where nothing is in the way, in closed form,
// and which share of it arrives, by shadow rays (a ratio estimator), `rays` of them drawn evenly, evenest by powers of
// 2, in proportion to that light. To narrow bright spots such as the sun, rays of their own: an eighth as many, and
// half where any disagrees.
std::vector<SkyLight> sky_irradiance(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                                     const std::vector<Place>& places, int rays, std::uint64_t seed,
                                     const Progress& progress = {});

// The same at places some of which may see little of the sky, as through a window. Where less than a fifth of its light
// arrives, about as many rays again are shot all over it, and as many into those parts of it around which some of the
// first were free. The first ones do not count then, so that the estimate stays unbiased, but for the choice whether
// they do. Fewer than 256 rays are not refined.
std::vector<SkyLight> refined_sky_irradiance(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                                             const std::vector<Place>& places, int rays, std::uint64_t seed,
                                             const Progress& progress = {});

// Finds those places of a scene anew, by refined_sky_irradiance of 512 rays or more, of which five times as much is
// hidden as places around them have of the sky (RMS of a thousand), and this is noise beside the `others`, luminance
// from elsewhere. These are most of a room with a window, and none in the open. `found` is of `rays`.
void refine_behind_openings(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                            const std::vector<Place>& places, int rays, const std::vector<double>& others,
                            std::uint64_t seed, const Progress& progress, const Team& team,
                            std::vector<SkyLight>& found);

}  // namespace surflux
