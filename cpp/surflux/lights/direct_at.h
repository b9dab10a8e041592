#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/lights/direct.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Irradiance from lights and Environments at points of the surface with normals, traced anew: shadow rays towards each
// light, and where there is an Environment `rays` cosine-distributed ones and as many light samples of its images,
// combined by multiple importance sampling.
std::vector<Rgb> direct_at(const Scene& scene, const Tracer& tracer, const std::vector<Vec3>& points,
                           const std::vector<Vec3>& normals, const DirectOptions& options, int rays, std::uint64_t seed,
                           const Progress& progress = {});

}  // namespace surflux
