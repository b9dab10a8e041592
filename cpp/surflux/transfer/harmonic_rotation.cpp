#include "surflux/transfer/harmonic_rotation.h"

#include <cmath>
#include <cstdlib>

#include <Eigen/Dense>

#include "surflux/core/error.h"
#include "surflux/transfer/spherical_harmonics.h"

namespace surflux {

namespace {

Eigen::Matrix3d nearest_rotation(const Vec3 (&rows)[3]) {
    Eigen::Matrix3d given;
    for (int i = 0; i < 3; ++i) {
        require(is_finite(rows[i]), "rotation: wanted finite numbers");
        given.row(i) << rows[i].x, rows[i].y, rows[i].z;
    }
    const double off = (given * given.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    require(off <= 2e-5,
            "rotation: wanted a rotation matrix, got rows that are not of unit length or not perpendicular (off by ",
            off, ")");
    require(given.determinant() > 0.0, "rotation: wanted a rotation matrix, got one that mirrors (determinant -1)");
    const Eigen::JacobiSVD<Eigen::Matrix3d> parts(given, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return parts.matrixU() * parts.matrixV().transpose();
}

// The matrices of bands 1, l - 1 and l, by m and n from -l to l.
struct Block {
    const double* entries;
    int band;
    double operator()(int m, int n) const { return entries[(m + band) * (2 * band + 1) + n + band]; }
};

// P of Ivanic and Ruedenberg's table 2: band 1 times the band below.
double joined(const Block& one, const Block& below, int i, int a, int n) {
    const int l = below.band + 1;
    if (n == l) return one(i, 1) * below(a, l - 1) - one(i, -1) * below(a, 1 - l);
    if (n == -l) return one(i, 1) * below(a, 1 - l) + one(i, -1) * below(a, l - 1);
    return one(i, 0) * below(a, n);
}

// Their eq. 8.1, with u, v, w of table 1 and U, V, W of table 2.
double turned(const Block& one, const Block& below, int m, int n) {
    const int l = below.band + 1, k = std::abs(m);
    const auto p = [&](int i, int a) { return joined(one, below, i, a, n); };
    const double under = std::abs(n) == l ? 2.0 * l * (2.0 * l - 1.0) : static_cast<double>((l + n) * (l - n));
    double sum = 0.0;
    if (k < l) sum += std::sqrt((l + m) * (l - m) / under) * p(0, m);
    if (m == 0) return sum - 0.5 * std::sqrt(2.0 * (l - 1.0) * l / under) * (p(1, 1) + p(-1, -1));
    const double v = 0.5 * std::sqrt((l + k - 1.0) * (l + k) / under);
    const double root = std::sqrt(2.0);
    if (m == 1) sum += v * root * p(1, 0);
    if (m == -1) sum += v * root * p(-1, 0);
    if (m > 1) sum += v * (p(1, m - 1) - p(-1, 1 - m));
    if (m < -1) sum += v * (p(1, m + 1) + p(-1, -m - 1));
    if (k > l - 2) return sum;
    const double w = -0.5 * std::sqrt((l - k - 1.0) * (l - k) / under);
    return sum + w * (m > 0 ? p(1, m + 1) + p(-1, -m - 1) : p(1, m - 1) - p(-1, 1 - m));
}

}  // namespace

HarmonicRotation::HarmonicRotation(const Vec3 (&rows)[3], int order) : order_(order) {
    require(order >= 1 && order <= SphericalHarmonics::largest_order, "order: wanted 1 to ",
            SphericalHarmonics::largest_order, " bands, got ", order);
    const Eigen::Matrix3d r = nearest_rotation(rows);
    bands_.push_back({1.0});
    // Band 1 is (y, z, x).
    const int axis[] = {1, 2, 0};
    std::vector<double> one;
    for (const int m : axis)
        for (const int n : axis) one.push_back(r(m, n));
    for (int l = 1; l < order; ++l) {
        if (l == 1) {
            bands_.push_back(one);
            continue;
        }
        std::vector<double> band;
        for (int m = -l; m <= l; ++m)
            for (int n = -l; n <= l; ++n) band.push_back(turned({one.data(), 1}, {bands_.back().data(), l - 1}, m, n));
        bands_.push_back(std::move(band));
    }
}

double HarmonicRotation::entry(int band, int m, int n) const {
    return Block{bands_[static_cast<std::size_t>(band)].data(), band}(m, n);
}

void HarmonicRotation::apply(const double* in, double* out, int channels) const {
    for (int l = 0; l < order_; ++l) {
        const auto first = static_cast<std::ptrdiff_t>(SphericalHarmonics::index(l, -l)) * channels;
        const double* row = bands_[static_cast<std::size_t>(l)].data();
        for (int m = 0; m < 2 * l + 1; ++m, row += 2 * l + 1)
            for (int c = 0; c < channels; ++c) {
                double sum = 0.0;
                for (int n = 0; n < 2 * l + 1; ++n) sum += row[n] * in[first + n * channels + c];
                out[first + m * channels + c] = sum;
            }
    }
}

}  // namespace surflux
