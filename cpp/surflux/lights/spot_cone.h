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
    double share(const Vec3& d) const { return of_angle(angle(d)); }
    double angle(const Vec3& d) const { return std::atan2(length(cross(d, axis_)), dot(d, axis_)); }
    // The integral of share(t) sin(t) from the axis to an angle: a cone's power is 2 pi within(pi).
    double within(double angle) const {
        if (angle <= inner_) return versine(angle);
        double sum = versine(inner_);
        // By Gauss and Legendre: smoothstep times sine, both smooth.
        constexpr double at[5] = {0.0, 0.5384693101056831, -0.5384693101056831, 0.9061798459386640,
                                  -0.9061798459386640};
        constexpr double weight[5] = {0.5688888888888889, 0.4786286704993665, 0.4786286704993665, 0.2369268850561891,
                                      0.2369268850561891};
        const double half = 0.5 * (std::min(angle, outer_) - inner_);
        for (int k = 0; k < 5; ++k) {
            const double t = inner_ + half * (1.0 + at[k]);
            sum += half * weight[k] * of_angle(t) * std::sin(t);
        }
        return sum;
    }
    const Vec3& axis() const { return axis_; }
    double inner() const { return inner_; }
    double outer() const { return outer_; }

private:
    static double versine(double angle) { return 2.0 * std::sin(0.5 * angle) * std::sin(0.5 * angle); }
    double of_angle(double angle) const {
        if (angle >= outer_) return 0.0;
        if (angle <= inner_) return 1.0;
        const double x = (outer_ - angle) / (outer_ - inner_);
        return x * x * (3.0 - 2.0 * x);
    }
    Vec3 axis_;
    double outer_, inner_;
};

}  // namespace surflux
