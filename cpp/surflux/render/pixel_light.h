#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/render/pixel_places.h"
#include "surflux/render/smooth_cells.h"
#include "surflux/scene/lights.h"
#include "surflux/trace/tracer.h"

namespace surflux {

struct PixelLightOptions {
    int penumbra_rays = 16;  // of a pixel towards a light that is more than a point, where not all of it is seen
    std::uint64_t seed = 0;
};

// Direct light at every pixel: the unoccluded kernel in closed form, times what is visible of the light. Shadow rays
// are traced for the probe of each cell (smooth_cells.h), and for all pixels beside which the answer is another, until
// shadows are closed: every shadow that a probe meets is exact to the pixel, and what is missed is smaller than a cell.
// Lights that are more than a point have a ray to another point of them for each probe; where these contradict each
// other, or a light is seen in part, every pixel has `penumbra_rays`, stratified.
class PixelLight {
public:
    // All must outlive this.
    PixelLight(const Tracer& tracer, const PixelPlaces& places, const SmoothCells& cells)
        : tracer_(tracer), places_(places), cells_(cells) {}

    // Memory of one picture at a time, so that most pictures allocate nothing.
    struct Scratch {
        std::vector<float> kernel, visible;  // by pixel
        std::vector<char> is_traced;
        std::vector<float> at_probes;  // by cell
    };

    // Irradiance by pixel, 3 each, from all lights but Environments. Returns how many shadow rays it took.
    std::size_t irradiance(const std::vector<Light>& lights, const PixelLightOptions& options, Scratch& scratch,
                           std::vector<float>& out) const;

private:
    const Tracer& tracer_;
    const PixelPlaces& places_;
    const SmoothCells& cells_;
};

}  // namespace surflux
