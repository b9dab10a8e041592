#pragma once

#include <vector>

#include "surflux/core/vec.h"

namespace surflux {

// Turns functions given by their spherical harmonics: coefficients f become those of g(R d) = f(d), so that a light
// that came from d comes from R d. It is a square matrix for each band, made from that of the band below by Ivanic and
// Ruedenberg's recurrence (J. Phys. Chem. 100, 1996, with the corrections of 102, 1998), which knows no angles and so
// no poles: its error is some roundings per band.
class HarmonicRotation {
public:
    // The rows of a rotation R, exact or rounded: within 1e-5 of one, which the nearest is taken for. An
    // ArgumentError for what stretches, and for what mirrors: the harmonics of a mirrored light are no rotation of it.
    HarmonicRotation(const Vec3 (&rows)[3], int order);

    int order() const { return order_; }
    // order^2 coefficients with `channels` numbers each, one after another; `out` must not be `in`.
    void apply(const double* in, double* out, int channels = 1) const;
    // D of a band: g_m = sum over n of entry(band, m, n) f_n.
    double entry(int band, int m, int n) const;

private:
    int order_;
    std::vector<std::vector<double>> bands_;  // (2 l + 1) x (2 l + 1), row by row
};

}  // namespace surflux
