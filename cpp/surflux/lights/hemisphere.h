#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// What each surfel's cosine-weighted hemisphere loses (ambient visibility), estimated by cosine-distributed rays.
struct Hemispheres {
    std::vector<double> escape;  // fraction (of the cosine-weighted hemisphere) that leaves the scene
    std::vector<double>
        absorbed;          // fraction that meets a back face, which is black, or leaves where something lies on it
    std::vector<Rgb> sky;  // irradiance from the Environments that are images: by rays of their own, closure apart
    Rgb constant_sky;      // radiance of the others, of which a surfel has pi times its escape
    std::vector<std::uint32_t> taken;  // rays per surfel that escape and absorbed come from
    std::size_t rays = 0;
};

// `rays` per surfel, spread evenly, the same for the same seed; four times as many where they do not all meet the same
// of front, back and nothing. Where an Environment is an image, as many again, drawn in proportion to its luminance and
// both combined by the balance heuristic (Veach and Guibas 1995).
Hemispheres measure_hemispheres(const Scene& scene, const Tracer& tracer, int rays, std::uint64_t seed,
                                const Progress& progress = {});

}  // namespace surflux
