#pragma once

#include <vector>

#include "surflux/core/vec.h"
#include "surflux/scene/lights.h"

namespace surflux {

// Spherical harmonics of the radiance of an Environment, order^2 of them, in the scene's axes: `up` and azimuth are in
// them. The radiance is what EnvironmentMap has, constant in each pixel, and integrated so: in azimuth in closed
// form, over the height of each row to rounding. Images without harmonics above the order come back as they were made
// but for what their pixels smooth.
std::vector<Rgb> project_environment(const Environment& environment, int order);

// An image of width x height pixels, each the mean over its solid angle of the function with these coefficients: what
// of all images of that size is nearest to it. Pixels are below 0 where the function is.
Environment environment_of_harmonics(const std::vector<Rgb>& coefficients, std::size_t width, std::size_t height);

}  // namespace surflux
