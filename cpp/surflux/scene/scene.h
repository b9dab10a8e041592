#pragma once

#include <cstdint>
#include <vector>

#include "surflux/scene/lights.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// All surfels of a scene in one list, and the object (reconstruction group, L07 6.1) that each belongs to.
struct Scene {
    Surfels surfels;
    std::vector<std::uint32_t> object;  // per surfel
    std::vector<Light> lights;
};

// Appends the surfels as a new object. Areas must be given for all objects or for none.
void append(Scene& scene, const Surfels& surfels);

}  // namespace surflux
