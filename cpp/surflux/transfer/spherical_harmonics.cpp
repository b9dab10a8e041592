#include "surflux/transfer/spherical_harmonics.h"

#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"

namespace surflux {

int SphericalHarmonics::order_of(std::size_t count, const char* name) {
    int order = 1;
    while (order < largest_order && SphericalHarmonics::count(order) < count) ++order;
    require(SphericalHarmonics::count(order) == count, name, ": wanted 1, 4, 9, 16, 25, ... coefficients, at most ",
            SphericalHarmonics::count(largest_order), ", got ", count);
    return order;
}

SphericalHarmonics::SphericalHarmonics(int order) : order_(order) {
    require(order >= 1 && order <= largest_order, "order: wanted 1 to ", largest_order, " bands, got ", order);
    ahead_.resize(size());
    back_.resize(size());
    for (int m = 0; m < order; ++m) {
        const double norm = m == 0 ? 1.0 / (4.0 * pi) : (2.0 * m + 1.0) / (2.0 * m) * (m == 1 ? 2.0 : 1.0);
        first_.push_back(m == 0 ? std::sqrt(norm) : first_.back() * std::sqrt(norm));
        for (int l = m + 1; l < order; ++l) {
            const double ahead = std::sqrt((4.0 * l * l - 1.0) / (static_cast<double>(l) * l - m * m));
            const double before = l - 1.0;
            ahead_[index(l, m)] = ahead;
            back_[index(l, m)] =
                l == m + 1 ? 0.0 : ahead * std::sqrt((before * before - m * m) / (4.0 * before * before - 1.0));
        }
    }
}

template <class With>
void SphericalHarmonics::each(double cosine, const With& with) const {
    for (int m = 0; m < order_; ++m) {
        double before = 0.0, at = first_[static_cast<std::size_t>(m)];
        with(m, m, at);
        for (int l = m + 1; l < order_; ++l) {
            const double next = ahead_[index(l, m)] * cosine * at - back_[index(l, m)] * before;
            before = at;
            at = next;
            with(l, m, at);
        }
    }
}

void SphericalHarmonics::evaluate(const Vec3& direction, double* values) const {
    // sin^m cos(m phi) and sin^m sin(m phi) are the real and imaginary parts of (x + i y)^m: no angle is needed, and
    // nothing is divided by the sine at the poles.
    double real[largest_order] = {1.0}, imaginary[largest_order] = {0.0};
    for (int m = 1; m < order_; ++m) {
        real[m] = direction.x * real[m - 1] - direction.y * imaginary[m - 1];
        imaginary[m] = direction.x * imaginary[m - 1] + direction.y * real[m - 1];
    }
    each(direction.z, [&](int l, int m, double value) {
        if (m > 0) values[index(l, -m)] = value * imaginary[m];
        values[index(l, m)] = value * real[m];
    });
}

void SphericalHarmonics::latitudes(double cosine, double sine, double* values) const {
    double power[largest_order] = {1.0};
    for (int m = 1; m < order_; ++m) power[m] = power[m - 1] * sine;
    each(cosine, [&](int l, int m, double value) { values[index(l, m)] = value * power[m]; });
}

std::vector<double> spherical_harmonics(const std::vector<Vec3>& directions, int order) {
    const SphericalHarmonics basis(order);
    std::vector<double> values(directions.size() * basis.size());
    parallel_for(directions.size(), 1024,
                 [&](std::size_t i) { basis.evaluate(directions[i], values.data() + i * basis.size()); });
    return values;
}

}  // namespace surflux
