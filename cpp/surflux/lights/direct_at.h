#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Irradiance from lights and Environments at points of the surface with normals, traced anew: up to `rays` shadow rays
// to the sky (sky_irradiance.h), and half as many to each light (direct.h), an eighth where they agree.
std::vector<Rgb> direct_at(const Scene& scene, const Tracer& tracer, const std::vector<Vec3>& points,
                           const std::vector<Vec3>& normals, int rays, std::uint64_t seed,
                           const Progress& progress = {});

// The same from small emissive surfels, which are sampled as lights are (LightSampler): a quarter as many light samples
// as `rays`, and as many cosine-distributed rays; a quarter of that where none find any, four times as many close to
// emitters.
std::vector<Rgb> emitted_at(const Scene& scene, const Tracer& tracer, const std::vector<Vec3>& points,
                            const std::vector<Vec3>& normals, int rays, std::uint64_t seed,
                            const Progress& progress = {});

}  // namespace surflux
