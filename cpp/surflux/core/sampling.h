#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

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

// Points of the unit cube of `dimensions` <= 4 that fill it evenly however many are taken, best by powers of 2: Sobol's
// sequence with the direction numbers of Joe and Kuo 2008, shifted digit by digit by the seed, which keeps its nets and
// makes it unbiased over seeds. Coordinates 0 and 1 together, and 2 and 3, are even too, as surfaces and lights need
// it. (Roberts' additive recurrence is not in four dimensions: 6/7 and 7/13 are close to its steps.)
class EvenPoints {
public:
    EvenPoints(int dimensions, std::uint64_t seed, std::uint64_t stream) : dimensions_(dimensions) {
        Random random(seed, stream);
        for (int d = 0; d < dimensions; ++d) bits_[d] = static_cast<std::uint32_t>(random.uniform() * 4294967296.0);
    }
    // The next point; coordinates beyond `dimensions` are 0.
    const double* next() {
        for (int d = 0; d < dimensions_; ++d) at_[d] = (bits_[d] + 0.5) / 4294967296.0;
        // In the order of Gray's code, one digit changes.
        int digit = 0;
        for (std::uint32_t rest = ++taken_; (rest & 1u) == 0u && digit < 31; rest >>= 1) ++digit;
        for (int d = 0; d < dimensions_; ++d) bits_[d] ^= directions[d][digit];
        return at_;
    }

private:
    using Directions = std::array<std::array<std::uint32_t, 32>, 4>;
    static constexpr Directions make_directions() {
        // Degree and inner coefficients of the primitive polynomials of coordinates 1 to 3, and their first numbers.
        constexpr int degree[4] = {0, 1, 2, 3};
        constexpr std::uint32_t inner[4] = {0, 0, 1, 1}, first[4][3] = {{}, {1}, {1, 3}, {1, 3, 1}};
        Directions v{};
        for (int k = 0; k < 32; ++k) v[0][static_cast<std::size_t>(k)] = 1u << (31 - k);
        for (std::size_t d = 1; d < 4; ++d)
            for (int k = 0; k < 32; ++k) {
                const int s = degree[d];
                const auto at = [&](int i) -> std::uint32_t& { return v[d][static_cast<std::size_t>(i)]; };
                if (k < s) {
                    at(k) = first[d][k] << (31 - k);
                    continue;
                }
                at(k) = at(k - s) ^ (at(k - s) >> s);
                for (int i = 1; i < s; ++i)
                    if ((inner[d] >> (s - 1 - i)) & 1u) at(k) ^= at(k - i);
            }
        return v;
    }
    static const Directions directions;

    int dimensions_;
    std::uint32_t taken_ = 0, bits_[4] = {};
    double at_[4] = {};
};

inline constexpr EvenPoints::Directions EvenPoints::directions = EvenPoints::make_directions();

}  // namespace surflux
