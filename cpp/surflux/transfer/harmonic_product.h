#pragma once

#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// Directions and weights that integrate every polynomial of up to this degree over the sphere exactly: Gauss and
// Legendre in z, evenly in azimuth. Weights sum to 4 pi.
struct SphereQuadrature {
    std::vector<Vec3> directions;
    std::vector<double> weights;
};
SphereQuadrature sphere_quadrature(int degree);

// Products of functions given by spherical harmonics, as the harmonics of the product up to an order: exact, since
// all three together are a polynomial that a quadrature integrates exactly. (The same as by the tripling coefficients,
// integrals of Y_i Y_j Y_k, which need no table here.)
class HarmonicProduct {
public:
    HarmonicProduct(int order_a, int order_b, int order_out);

    // Coefficients of a b, order_out^2 of them.
    void multiply(const double* a, const double* b, double* out) const;
    // The matrix of "times a", order_out^2 rows of order_b^2: integrals of a Y_row Y_column.
    std::vector<double> matrix(const double* a) const;

private:
    int order_a_, order_b_, order_out_;
    std::vector<double> weights_;
    std::vector<double> harmonics_;  // of the highest order, one row for each direction
};

}  // namespace surflux
