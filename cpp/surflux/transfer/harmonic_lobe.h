#pragma once

#include <vector>

namespace surflux {

// Factors of bands by which harmonics are convolved with the lobe max(cos, 0)^exponent, exponent >= 0: coefficients of
// f times them are those of the integral of f over directions w, times the lobe around the given direction (Funk and
// Hecke). Exponent 1 is irradiance, pi, 2 pi/3, pi/4, 0, -pi/24, ... (Ramamoorthi and Hanrahan 2001, eq. 19); Phong
// lobes are the others; times (exponent + 1) / (2 pi) they integrate to 1.
std::vector<double> lobe_bands(double exponent, int order);

// The same with a cap of so many steradians, up to a hemisphere, of which the mean is taken, into `order` factors.
void cap_bands(double solid_angle, int order, double* bands);

// Coefficients, `channels` numbers each, times the factors of their bands.
void scale_bands(const double* factors, int order, double* coefficients, int channels = 1);
void scale_bands(const std::vector<double>& factors, double* coefficients, int channels = 1);

}  // namespace surflux
