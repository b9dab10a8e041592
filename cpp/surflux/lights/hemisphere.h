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
        absorbed;      // fraction that meets a back face, which is black, or leaves where something lies on it
    Rgb constant_sky;  // radiance of Environments that are no images, of which a surfel has pi times its escape
    std::vector<std::uint32_t> taken;  // rays per surfel that escape and absorbed come from
    std::size_t rays = 0;
};

// `rays` per surfel, spread evenly, the same for the same seed; four times as many where they do not all meet the same
// of front, back and nothing.
Hemispheres measure_hemispheres(const Scene& scene, const Tracer& tracer, int rays, std::uint64_t seed,
                                const Progress& progress = {});

}  // namespace surflux
