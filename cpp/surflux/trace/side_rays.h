#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// What a ray from a side of a sheet met: nothing, or a surfel on the side that its front points to.
struct Met {
    std::uint32_t surfel = Hit::none;
    bool front = false;
};

// Rays from both sides of surfels, of which each sees but its front: so there are two scenes, and a ray is traced in
// that where its surfel faces its way.
class SideRays {
public:
    // `fronts`: unit normals, alike where surfels continue each other.
    SideRays(const Surfels& surfels, const std::vector<Vec3>& fronts);

    // `rays` rays from the front of each of `from`, or from behind.
    std::vector<Met> cast(const std::vector<std::uint32_t>& from, const std::vector<Vec3>& fronts, bool behind,
                          int rays, std::uint64_t seed, const Progress& progress) const;
    const Tracer& tracer() const { return *tracers_[0]; }

private:
    std::array<Scene, 2> scenes_;
    std::array<std::unique_ptr<Tracer>, 2> tracers_;
};

}  // namespace surflux
