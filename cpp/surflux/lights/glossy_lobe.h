#pragma once

#include <algorithm>
#include <cmath>

#include "surflux/core/sampling.h"
#include "surflux/core/vec.h"

namespace surflux {

// What a place on a surface sends in one direction `out` of the light that comes to it: diffuse / pi, as cosine, and
// specular times a lobe (s + 1) / (2 pi) cos^s around the mirror direction of `out`, without a cosine: Phong's model,
// f cos(n, w) = (s + 1) / (2 pi) cos(r, w)^s, as spherical harmonics convolve (Sloan, Kautz and Snyder 2002). Of the
// lobe, what lies below the surface is lost. It is not reciprocal; nothing is sent of more than diffuse + specular.
class GlossyLobe {
public:
    GlossyLobe(const Vec3& normal, const Vec3& out, const Rgb& diffuse, const Rgb& specular, double exponent)
        : normal_(normal),
          mirror_(2.0 * dot(normal, out) * normal - out),
          diffuse_(diffuse),
          specular_(specular),
          exponent_(exponent) {
        const double all = sum(diffuse) + sum(specular);
        share_ = all > 0.0 ? sum(specular) / all : 0.0;
    }

    const Vec3& normal() const { return normal_; }
    // Reflected radiance for each unit of radiance and of solid angle from a unit direction; 0 from below.
    Rgb value(const Vec3& direction) const {
        const double cosine = dot(normal_, direction);
        if (!(cosine > 0.0)) return {};
        return (cosine / pi) * diffuse_ + lobe(direction) * specular_;
    }
    // Of a direction as sample() draws them, and draws of it: choice says which part, for all in [0, 1).
    double density(const Vec3& direction) const {
        return (1.0 - share_) * std::max(0.0, dot(normal_, direction)) / pi + share_ * lobe(direction);
    }
    Vec3 sample(double s, double t, double choice) const {
        if (choice >= share_) return frame_around(normal_).to_world(square_to_cosine_hemisphere(s, t));
        // The disk of cosine-distributed directions, cos^2 uniform, to cos^(s + 1) uniform: strata stay whole.
        double x, y;
        square_to_disk(s, t, x, y);
        const double rest = std::max(1e-300, 1.0 - x * x - y * y);
        const double cosine = std::pow(rest, 1.0 / (exponent_ + 1.0));
        const double wide = x * x + y * y, sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
        const double k = wide > 0.0 ? sine / std::sqrt(wide) : 0.0;
        return frame_around(mirror_).to_world({k * x, k * y, cosine});
    }

private:
    static double sum(const Rgb& c) { return c.x + c.y + c.z; }
    double lobe(const Vec3& direction) const {
        const double cosine = dot(mirror_, direction);
        return cosine > 0.0 ? (exponent_ + 1.0) / (2.0 * pi) * std::pow(cosine, exponent_) : 0.0;
    }

    Vec3 normal_, mirror_;
    Rgb diffuse_, specular_;
    double exponent_, share_ = 0.0;
};

}  // namespace surflux
