#pragma once

#include <algorithm>
#include <cmath>

#include "surflux/core/random.h"
#include "surflux/core/vec.h"

namespace surflux {

constexpr double pi = 3.14159265358979323846;

// Unit square -> unit disk, area preserving and continuous (Shirley and Chiu 1997).
inline void square_to_disk(double s, double t, double& x, double& y) {
    const double a = 2.0 * s - 1.0, b = 2.0 * t - 1.0;
    if (a == 0.0 && b == 0.0) return void(x = y = 0.0);
    double radius, angle;
    if (std::abs(a) > std::abs(b)) {
        radius = a;
        angle = (pi / 4.0) * (b / a);
    } else {
        radius = b;
        angle = pi / 2.0 - (pi / 4.0) * (a / b);
    }
    x = radius * std::cos(angle);
    y = radius * std::sin(angle);
}

// Unit square -> hemisphere around +z, density cos(theta)/pi (Malley).
inline Vec3 square_to_cosine_hemisphere(double s, double t) {
    Vec3 d;
    square_to_disk(s, t, d.x, d.y);
    d.z = std::sqrt(std::max(0.0, 1.0 - d.x * d.x - d.y * d.y));
    return d;
}

// Unit square -> barycentric weights of a uniformly distributed point of a triangle.
inline Vec3 square_to_triangle(double s, double t) {
    const double root = std::sqrt(s);
    return {1.0 - root, root * (1.0 - t), root * t};
}

// Points of the unit cube of `dimensions` <= 4 that fill it evenly however many are taken: Roberts' additive recurrence
// R_d, shifted by the seed (Cranley and Patterson 1976). Without noise where a few suffice, unbiased over seeds.
class EvenPoints {
public:
    EvenPoints(int dimensions, std::uint64_t seed, std::uint64_t stream) : dimensions_(dimensions) {
        // The unique real root above 1 of x^(d+1) = x + 1.
        constexpr double root[5] = {0.0, 1.6180339887498949, 1.3247179572447460, 1.2207440846057596,
                                    1.1673039782614187};
        Random random(seed, stream);
        double alpha = 1.0;
        for (int d = 0; d < dimensions; ++d) {
            alpha /= root[dimensions];
            alpha_[d] = alpha;
            at_[d] = random.uniform();
        }
    }
    // The next point; coordinates beyond `dimensions` are 0.
    const double* next() {
        for (int d = 0; d < dimensions_; ++d) at_[d] -= std::floor(at_[d] += alpha_[d]);
        return at_;
    }

private:
    int dimensions_;
    double alpha_[4] = {}, at_[4] = {};
};

}  // namespace surflux
