#include "surflux/transfer/harmonic_product.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/gauss_legendre.h"
#include "surflux/core/sampling.h"
#include "surflux/transfer/spherical_harmonics.h"

namespace surflux {

namespace {

double value_at(const double* harmonics, const double* coefficients, std::size_t count) {
    double sum = 0.0;
    for (std::size_t i = 0; i < count; ++i) sum += harmonics[i] * coefficients[i];
    return sum;
}

}  // namespace

SphereQuadrature sphere_quadrature(int degree) {
    std::vector<double> nodes, shares;
    gauss_legendre(degree / 2 + 1, nodes, shares);
    const int around = degree + 1;
    SphereQuadrature out;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        const double z = 2.0 * nodes[k] - 1.0, r = std::sqrt(1.0 - z * z);
        for (int j = 0; j < around; ++j) {
            const double phi = 2.0 * pi * (j + 0.5) / around;
            out.directions.push_back({r * std::cos(phi), r * std::sin(phi), z});
            out.weights.push_back(4.0 * pi * shares[k] / around);
        }
    }
    return out;
}

HarmonicProduct::HarmonicProduct(int order_a, int order_b, int order_out)
    : order_a_(order_a), order_b_(order_b), order_out_(order_out) {
    // Checks that all three are orders, the widest alone being evaluated.
    const SphericalHarmonics checked[] = {SphericalHarmonics(order_a), SphericalHarmonics(order_b),
                                          SphericalHarmonics(order_out)};
    const int degree = checked[0].order() + checked[1].order() + checked[2].order() - 3;
    SphereQuadrature quadrature = sphere_quadrature(degree);
    harmonics_ = spherical_harmonics(quadrature.directions, std::max({order_a, order_b, order_out}));
    weights_ = std::move(quadrature.weights);
}

void HarmonicProduct::multiply(const double* a, const double* b, double* out) const {
    const std::size_t count = SphericalHarmonics::count(order_out_), stride = harmonics_.size() / weights_.size();
    std::fill_n(out, count, 0.0);
    for (std::size_t k = 0; k < weights_.size(); ++k) {
        const double* at = harmonics_.data() + k * stride;
        const double value = weights_[k] * value_at(at, a, SphericalHarmonics::count(order_a_)) *
                             value_at(at, b, SphericalHarmonics::count(order_b_));
        for (std::size_t i = 0; i < count; ++i) out[i] += value * at[i];
    }
}

std::vector<double> HarmonicProduct::matrix(const double* a) const {
    const std::size_t rows = SphericalHarmonics::count(order_out_), columns = SphericalHarmonics::count(order_b_);
    const std::size_t stride = harmonics_.size() / weights_.size();
    std::vector<double> out(rows * columns, 0.0);
    for (std::size_t k = 0; k < weights_.size(); ++k) {
        const double* at = harmonics_.data() + k * stride;
        const double value = weights_[k] * value_at(at, a, SphericalHarmonics::count(order_a_));
        for (std::size_t i = 0; i < rows; ++i)
            for (std::size_t j = 0; j < columns; ++j) out[i * columns + j] += value * at[i] * at[j];
    }
    return out;
}

}  // namespace surflux
