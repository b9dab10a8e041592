#pragma once

#include "surflux/scene/scene.h"

namespace surflux {

// Throws ArgumentError, naming the array, unless the scene is one as compile_scene makes them: arrays of one length,
// numbers in their ranges, every index with something that it stands for. For scenes from files, which anybody may
// have written.
void require_whole(const Scene& scene);

}  // namespace surflux
