#pragma once

#include <cstddef>
#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// Real spherical harmonics Y_lm, orthonormal over the sphere, of bands l < order: order^2 of them, with that of band l
// and -l <= m <= l at l (l + 1) + m. Signs are those of graphics (Ramamoorthi and Hanrahan 2001: no Condon-Shortley
// phase), so that band 1 is sqrt(3 / (4 pi)) times (y, z, x). L07 sec. 6.4 has order 5.
class SphericalHarmonics {
public:
    static constexpr int largest_order = 32;
    static constexpr std::size_t count(int order) {
        return static_cast<std::size_t>(order) * static_cast<std::size_t>(order);
    }
    static constexpr std::size_t index(int band, int m) { return static_cast<std::size_t>(band * (band + 1) + m); }
    // The order that has so many harmonics; an ArgumentError by that name where there is none.
    static int order_of(std::size_t count, const char* name);

    explicit SphericalHarmonics(int order);
    int order() const { return order_; }
    std::size_t size() const { return count(order_); }

    // All of them in a unit direction, into values[0, size()).
    void evaluate(const Vec3& direction, double* values) const;
    // Y_lm = latitude(l, m) times cos(m phi), of m < 0 sin(-m phi), at the angle from +z with this cosine and sine;
    // into values at index(l, m), m >= 0, the others untouched.
    void latitudes(double cosine, double sine, double* values) const;

private:
    // Calls with(l, m, Y) for m >= 0, Y without its factor sin^m: by recurrences in l that are stable for any order,
    // of functions with their norm in them, so that nothing grows (Press and others, Numerical Recipes, sec. 6.7).
    template <class With>
    void each(double cosine, const With& with) const;

    int order_;
    std::vector<double> first_;         // of each m, Y_mm without sin^m
    std::vector<double> ahead_, back_;  // at index(l, m), m >= 0: factors of Y_(l-1)m cos(theta) and of Y_(l-2)m
};

// Harmonics in n unit directions, one row of order^2 after another.
std::vector<double> spherical_harmonics(const std::vector<Vec3>& directions, int order);

}  // namespace surflux
