#pragma once

#include "surflux/core/vec.h"

namespace surflux {

// A rectangle seen as a uniform light from the side that u x v points to, and not at all from behind.
struct VisibleEmitter {
    Vec3 corner, u, v;
    Rgb radiance;
};

}  // namespace surflux
