#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/lights/sample_points.h"
#include "surflux/lights/sky_cells.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Irradiance of each place from the images of Environments, on the shapes of `points`: what each cell of the sky brings
// to the place where nothing is in the way, in closed form, and which share of it arrives, by shadow rays (a ratio
// estimator), `rays` of them drawn evenly, evenest by powers of 2, in proportion to that light. To narrow bright spots
// such as the sun, rays of their own: an eighth as many, and half where any disagrees. `errors`: the estimated standard
// error of the luminance of each, 0 where all rays agree.
std::vector<Rgb> sky_irradiance(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                                const std::vector<Place>& places, int rays, std::uint64_t seed,
                                const Progress& progress = {}, std::vector<float>* errors = nullptr);

// The same at places that are points, some of which may see little of the sky, as through a window. Where less than a
// fifth of its light arrives, about as many rays again are shot all over it, and as many into those parts of it around
// which some of the first were free. The first ones do not count then, so that the estimate stays unbiased, but for the
// choice whether they do. Fewer than 256 rays are not refined.
std::vector<Rgb> refined_sky_irradiance(const Tracer& tracer, const SkyCells& sky, const SurfelPoints& points,
                                        const std::vector<Place>& places, int rays, std::uint64_t seed,
                                        const Progress& progress = {});

}  // namespace surflux
