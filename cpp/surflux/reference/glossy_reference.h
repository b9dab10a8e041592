#pragma once

#include <vector>

#include "surflux/lights/glossy_lobe.h"
#include "surflux/reference/reference.h"

namespace surflux {

// Places whose outgoing radiance is wanted, with unit normals and directions (away from the surface), and what they
// are made of. Of the materials each array may be empty: of the surfel that a point lies on.
struct GlossyPlaces {
    std::vector<Vec3> points, normals, directions;
    std::vector<Rgb> reflectance, specular;
    std::vector<double> exponents;
};

struct GlossyOptions : ReferenceOptions {
    // Do surfels, too, send light on by their specular part? Else by their diffuse one alone, as for solvers.
    bool glossy_bounces = true;
};

// Radiance that leaves the places in their directions, emission included, by path tracing as reference_irradiance does
// it, unbiased for the reflection of GlossyLobe at the places and, by option, wherever paths come. 0 in directions
// behind a place: backs are black. `irradiance` of the result is radiance.
Reference reference_radiance(const CompiledScene& compiled, const GlossyPlaces& places, const GlossyOptions& options,
                             const Progress& progress = {});

}  // namespace surflux
