#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/lights/sample_points.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

struct DirectOptions {
    // Shadow rays of a surfel towards a light; where all agree, or all but one, that is the answer. Patches have more
    // that are more than a 256th of all that are no wider (SizeShares), by their share.
    int probes = 16;
    int rays = 64;  // where they do not
    // Estimated errors of patches that no probe found lit: as if one had, instead of 0.
    bool dark_has_error = false;
};

// Irradiance at places on the shapes of `points` from every light but the Environments (see sky_irradiance.h), with
// shadows: the unoccluded irradiance (in closed form for point lights, and over area lights) times the fraction that
// shadow rays find visible, a ratio estimator: no variance outside penumbrae. `errors`: the estimated standard error of
// each, 0 where all rays agree.
std::vector<Rgb> direct_irradiance(const Scene& scene, const Tracer& tracer, const SurfelPoints& points,
                                   const std::vector<Place>& places, const DirectOptions& options, std::uint64_t seed,
                                   const Progress& progress = {}, std::vector<Rgb>* errors = nullptr);

// The same from any lights.
std::vector<Rgb> direct_irradiance(const Scene& scene, const std::vector<Light>& lights, const Tracer& tracer,
                                   const SurfelPoints& points, const std::vector<Place>& places,
                                   const DirectOptions& options, std::uint64_t seed, const Progress& progress = {},
                                   std::vector<Rgb>* errors = nullptr);

}  // namespace surflux
