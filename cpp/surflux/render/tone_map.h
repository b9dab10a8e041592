#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace surflux {

struct ToneMapOptions {
    std::optional<double> exposure;  // factor on radiance; chosen from the picture where not given
    bool filmic = true;              // a shoulder that bends highlights towards 1, else they are cut off there
};

// The factor that brings the log-average luminance of a picture to 0.22. It is taken over the pixels that are finite
// and brighter than 0. Left out are a background and lamps, told by one and the same value in more than 1 % of the
// pixels, and of the rest the darkest and the brightest 2 %. 1 where no pixel is bright.
double automatic_exposure(const std::vector<float>& rgb);

// Linear radiance -> linear display values in 0..1 (to be sRGB-encoded, which write_image does for .png), 3 per pixel.
// NaN and negative values give 0, infinity 1.
std::vector<float> tone_map(const std::vector<float>& rgb, const ToneMapOptions& options = {});

}  // namespace surflux
