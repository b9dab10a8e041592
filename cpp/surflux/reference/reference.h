#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/team.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/trace/compiled_scene.h"

namespace surflux {

struct ReferenceOptions {
    std::size_t samples = 4096;  // paths per point, rounded up to equal batches
    std::uint64_t seed = 0;
    double small_emitters = LightSampler::usual_small_emitters;
    Team team = {};
};

struct Reference {
    std::vector<Rgb> irradiance;
    std::vector<Rgb> error;   // standard error of each
    std::size_t batches = 0;  // independent estimates of each point that the error comes from
    std::size_t rays = 0;     // traced, shadow rays included
};

// Irradiance at points with unit normals by path tracing (Kajiya 1986), unbiased for this model:
// - The surfaces are the disks up to their ends, and the triangles of surfels that have some, exactly as Tracer has
//   them. What a ray
//   meets first is what it sees: where disks overlap, the first one's reflectance and emission count, and paths go on
//   from where it was met. Disks that stand off a curved surface are seen where they stand, rims and all.
// - The radiance that leaves the front of a surfel is (E + rho H) / pi, with H the irradiance at that place, on the
//   surfel's normal. Backs are black. What leaves the scene meets the Environments.
// - A path leaves its place by the rule of Tracer::closest for rays from anywhere; the points given, from
//   Tracer::departure. Lights neither occlude nor reflect.
// The samples of a point come in batches of evenly spread paths, each batch randomized on its own: their means are
// independent, so that (estimate - truth) / error follows Student's t with batches - 1 degrees of freedom.
Reference reference_irradiance(const CompiledScene& compiled, const std::vector<Vec3>& points,
                               const std::vector<Vec3>& normals, const ReferenceOptions& options,
                               const Progress& progress = {});

// Where paths leave from: Tracer::departure of points near the scene, an ArgumentError for others. Points that rounding
// puts behind their surface are moved up to it (onto_surface).
std::vector<Departure> departures(const CompiledScene& scene, const std::vector<Vec3>& points,
                                  const std::vector<Vec3>& normals);

}  // namespace surflux
