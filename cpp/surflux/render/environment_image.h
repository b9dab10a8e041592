#pragma once

#include <cstddef>
#include <vector>

#include "surflux/render/camera.h"
#include "surflux/scene/lights.h"

namespace surflux {

// Radiance of the Environments among `lights`, added up, in the directions in which a camera looks: 3 numbers a pixel,
// rows from the top, means over samples x samples subpixels. Each pixel times what is left of it, 1 - coverage, which
// is one number for each: this is what a picture of that coverage has to be given. Throws ArgumentError, naming the
// argument.
std::vector<float> environment_image(const std::vector<Light>& lights, const Camera& camera, std::size_t width,
                                     std::size_t height, int samples, const std::vector<float>& coverage);

}  // namespace surflux
