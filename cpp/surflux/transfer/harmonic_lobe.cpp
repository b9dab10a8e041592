#include "surflux/transfer/harmonic_lobe.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/sampling.h"
#include "surflux/transfer/spherical_harmonics.h"

namespace surflux {

std::vector<double> lobe_bands(double exponent, int order) {
    require(exponent >= 0.0 && std::isfinite(exponent), "exponent: wanted a number of at least 0, got ", exponent);
    require(order >= 1 && order <= SphericalHarmonics::largest_order, "order: wanted 1 to ",
            SphericalHarmonics::largest_order, " bands, got ", order);
    // 2 pi times the integral of z^s P_l(z) over [0, 1], which is I_l = I_(l-2) (s - l + 2) / (s + l + 1): from
    // Legendre's equation, integrated by parts twice. It ends where s is whole and l - s even and positive.
    std::vector<double> bands;
    for (int l = 0; l < order; ++l)
        bands.push_back(l < 2 ? 2.0 * pi / (exponent + 1.0 + l)
                              : bands[static_cast<std::size_t>(l) - 2] * (exponent - l + 2.0) / (exponent + l + 1.0));
    return bands;
}

void cap_bands(double solid_angle, int order, double* bands) {
    // The integral of P_l over [z, 1] is (P_(l-1)(z) - P_(l+1)(z)) / (2 l + 1).
    const double z = 1.0 - std::clamp(solid_angle / (2.0 * pi), 1e-6, 1.0);
    double before = 1.0, at = z;
    bands[0] = 1.0;
    for (int l = 1; l < order; ++l) {
        const double next = ((2 * l + 1) * z * at - l * before) / (l + 1);
        bands[l] = (before - next) / ((2 * l + 1) * (1.0 - z));
        before = at, at = next;
    }
}

void scale_bands(const double* factors, int order, double* coefficients, int channels) {
    for (int l = 0; l < order; ++l)
        for (int k = 0; k < (2 * l + 1) * channels; ++k) *coefficients++ *= factors[l];
}

void scale_bands(const std::vector<double>& factors, double* coefficients, int channels) {
    scale_bands(factors.data(), static_cast<int>(factors.size()), coefficients, channels);
}

}  // namespace surflux
