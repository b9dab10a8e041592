#pragma once

#include <cstdint>
#include <vector>

#include "surflux/render/pixel_places.h"
#include "surflux/scene/lights.h"

namespace surflux {

// Area lights in front of what pixels see, from their fronts: they move, and surfaces do not.
struct SeenLamps {
    static constexpr std::int32_t none = -1;

    std::vector<std::int32_t> lamp;  // of each pixel, an index among the lights, or none; empty where none is in view
    std::vector<float> depth;        // of lamps and surfaces

    std::int32_t at(std::size_t pixel) const { return lamp.empty() ? none : lamp[pixel]; }
};

// Takes the memory of what `out` was before.
void find_lamps(const std::vector<Light>& lights, const PixelPlaces& places, SeenLamps& out);

}  // namespace surflux
