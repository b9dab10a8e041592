#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "surflux/scene/lights.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// What of its intensity a photometric light sends by direction.
class PhotometricWeb {
public:
    explicit PhotometricWeb(const PhotometricLight& light);
    // Along d, from the light, of any length.
    double share(const Vec3& d) const;
    // Its integral over all directions, and over those from a place to a triangle.
    double power() const { return power_; }
    double power(const Vec3& from, const Triangle& t) const;
    // Half the angle of a cone that would hold its power at its largest share; pi for what shines alike all around.
    double beam() const { return beam_; }

    // Directions by its power: exact between the angles of a fine ladder, even about the axis.
    class Rays {
    public:
        explicit Rays(const PhotometricWeb& web);
        // By a point of [0, 1)^2: a direction, and what it stands for, in proportion.
        std::pair<Vec3, double> draw(double u, double v) const;

    private:
        const PhotometricWeb& web_;
        std::vector<double> up_to_;  // share of the power in all rings up to and with each
    };

private:
    Vec3 along(double cosine, double turn) const;
    double power(const Vec3 (&corners)[3], int depth) const;

    Vec3 axis_, zero_, quarter_;
    std::vector<double> planes_, angles_, table_;
    double power_ = 0.0, beam_ = 0.0, step_ = 0.0;
};

}  // namespace surflux
