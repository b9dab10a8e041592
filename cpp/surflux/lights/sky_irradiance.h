#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/lights/sample_points.h"
#include "surflux/lights/sky_cells.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// What arrives at places from the images of Environments. `errors`: estimated standard errors of the luminance, 0 where
// all rays agree; `hidden`: of the luminance, what surfaces keep off, without narrow bright spots.
struct SkyLight {
    std::vector<Rgb> irradiance;
    std::vector<float> errors, hidden;
};

// On the shapes of `points`: what each cell of the sky brings to the place where nothing is in the way, in closed form,
// and which share of it arrives, by shadow rays (a ratio estimator), `rays` of them drawn evenly, evenest by powers of
// 2, in proportion to that light. To narrow bright spots such as the sun, rays of their own: an eighth as many, and
// half where any disagrees.
SkyLight sky_irradiance(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                        const std::vector<Place>& places, int rays, std::uint64_t seed, const Progress& progress = {});

// The same at places some of which may see little of the sky, as through a window. Where less than a fifth of its light
// arrives, about as many rays again are shot all over it, and as many into those parts of it around which some of the
// first were free. The first ones do not count then, so that the estimate stays unbiased, but for the choice whether
// they do. Fewer than 256 rays are not refined.
SkyLight refined_sky_irradiance(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                                const std::vector<Place>& places, int rays, std::uint64_t seed,
                                const Progress& progress = {});

// RMS of the luminance of light(k), k < count.
template <class Light>
double rms_luminance(std::size_t count, const Light& light) {
    double squares = 0.0;
    for (std::size_t k = 0; k < count; ++k) squares += luminance(light(k)) * luminance(light(k));
    return count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0.0;
}

// Of a scene whose surfels have irradiance of the RMS `level`: finds those of `found`, which are of `rays`, anew by
// refined_sky_irradiance, 512 rays or more, of which five times as much is hidden. These are most of a room with a
// window, and none in the open.
void refine_behind_openings(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                            const std::vector<Place>& places, int rays, double level, std::uint64_t seed,
                            const Progress& progress, const Team& team, SkyLight& found);

}  // namespace surflux
