#pragma once

#include <vector>

#include "surflux/area/coincidence.h"
#include "surflux/core/progress.h"
#include "surflux/scene/scene.h"

namespace surflux {

// One scene of objects and lights, with what passes want to know of it: effective areas of objects that have none,
// where disks end, and what coincides, which counts once (count_once) and goes to `coincidence`. Of what objects know
// of ends nothing is taken: they may be parts of others.
Scene compile_scene(const std::vector<const Surfels*>& objects, std::vector<Light> lights, Coincidence& coincidence,
                    const Progress& progress = {});

}  // namespace surflux
