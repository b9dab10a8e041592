#pragma once

#include <algorithm>
#include <cmath>

#include "surflux/core/sampling.h"
#include "surflux/scene/lights.h"

namespace surflux {

// What a spot light leaves of its intensity by direction: all within half of (cone - penumbra) of the axis, 0 from half
// of the cone on, smoothstep in angle between.
class SpotCone {
public:
    explicit SpotCone(const SpotLight& light)
        : axis_(light.direction),
          outer_(light.cone * pi / 360.0),
          inner_(std::max(0.0, light.cone - light.penumbra) * pi / 360.0) {}
    // Along d, from the light, of any length.
    double share(const Vec3& d) const {
        const double angle = std::atan2(length(cross(d, axis_)), dot(d, axis_));
        if (angle >= outer_) return 0.0;
        if (angle <= inner_) return 1.0;
        const double x = (outer_ - angle) / (outer_ - inner_);
        return x * x * (3.0 - 2.0 * x);
    }

private:
    Vec3 axis_;
    double outer_, inner_;
};

}  // namespace surflux
