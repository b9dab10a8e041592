#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "refusal.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/environment.h"
#include "surflux/transfer/harmonic_lobe.h"
#include "surflux/transfer/harmonic_product.h"
#include "surflux/transfer/harmonic_projection.h"
#include "surflux/transfer/harmonic_rotation.h"
#include "surflux/transfer/spherical_harmonics.h"

namespace surflux {
namespace {

std::vector<double> random_numbers(std::size_t count, std::uint64_t seed) {
    Random random(seed, 0);
    std::vector<double> out(count);
    for (double& x : out) x = 2.0 * random.uniform() - 1.0;
    return out;
}

TEST(SphericalHarmonics, AreOrthonormalByAQuadratureThatIsExact) {
    const SphereQuadrature quadrature = sphere_quadrature(2 * 9);
    double all = 0.0;
    for (double weight : quadrature.weights) all += weight;
    EXPECT_NEAR(all, 4.0 * pi, 1e-13);
    const std::vector<double> y = spherical_harmonics(quadrature.directions, 10);
    for (std::size_t i = 0; i < 100; ++i)
        for (std::size_t j = 0; j < 100; ++j) {
            double sum = 0.0;
            for (std::size_t k = 0; k < quadrature.weights.size(); ++k)
                sum += quadrature.weights[k] * y[100 * k + i] * y[100 * k + j];
            ASSERT_NEAR(sum, i == j ? 1.0 : 0.0, 1e-13) << i << " " << j;
        }
}

TEST(SphericalHarmonics, TheirLatitudesTimesAnglesAreThey) {
    const SphericalHarmonics basis(8);
    std::vector<double> values(64), latitude(64);
    const double theta = 0.7, phi = 2.9;
    basis.evaluate({std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)}, values.data());
    basis.latitudes(std::cos(theta), std::sin(theta), latitude.data());
    for (int l = 0; l < 8; ++l)
        for (int m = -l; m <= l; ++m) {
            const double around = m < 0 ? std::sin(-m * phi) : std::cos(m * phi);
            EXPECT_NEAR(values[SphericalHarmonics::index(l, m)],
                        latitude[SphericalHarmonics::index(l, std::abs(m))] * around, 1e-14);
        }
}

TEST(HarmonicRotation, HasOrthogonalMatricesWhateverTheOrder) {
    // The columns of one band are the turned harmonics: orthonormal as they were, after 31 steps of the recurrence.
    const Vec3 n = normalized({0.3, -0.5, 0.8});
    const Frame frame = frame_around(n);
    const HarmonicRotation rotation({frame.u, frame.v, frame.n}, 32);
    for (int l = 0; l < 32; ++l)
        for (int a = -l; a <= l; ++a)
            for (int b = -l; b <= l; ++b) {
                double sum = 0.0;
                for (int m = -l; m <= l; ++m) sum += rotation.entry(l, m, a) * rotation.entry(l, m, b);
                ASSERT_NEAR(sum, a == b ? 1.0 : 0.0, 1e-11) << l;
            }
}

TEST(HarmonicProduct, IsItsMatrixTimesTheOther) {
    const HarmonicProduct product(5, 4, 6);
    const std::vector<double> a = random_numbers(25, 1), b = random_numbers(16, 2), matrix = product.matrix(a.data());
    std::vector<double> out(36);
    product.multiply(a.data(), b.data(), out.data());
    ASSERT_EQ(matrix.size(), 36u * 16u);
    for (std::size_t i = 0; i < 36; ++i) {
        double sum = 0.0;
        for (std::size_t j = 0; j < 16; ++j) sum += matrix[16 * i + j] * b[j];
        EXPECT_NEAR(out[i], sum, 1e-13);
    }
}

TEST(HarmonicLobe, AddsUpToItsMean) {
    // A constant seen through the lobe: times the integral of the lobe, 2 pi / (exponent + 1).
    std::vector<double> coefficients{1, 2, 1, 1, 1, 1, 1, 1};
    scale_bands(lobe_bands(3.0, 2), coefficients.data(), 2);
    EXPECT_DOUBLE_EQ(coefficients[0], 2.0 * pi / 4.0);
    EXPECT_DOUBLE_EQ(coefficients[1], 4.0 * pi / 4.0);
    EXPECT_DOUBLE_EQ(coefficients[7], 2.0 * pi / 5.0);
}

TEST(HarmonicProjection, OfAnImageOfHarmonicsIsTheHarmonics) {
    // What means over pixels of d radians leave out of f changes its product with Y by d^2 / 12 times the product of
    // their gradients, l (l + 1) f: for l = 4, d = pi / 64 and three channels of at most 1, sqrt(3) .004 at most, and
    // a quarter of it with each size.
    std::vector<Rgb> given(25);
    const std::vector<double> numbers = random_numbers(75, 3);
    for (std::size_t i = 0; i < 25; ++i) given[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
    double error[2] = {0.0, 0.0};
    for (int k = 0; k < 2; ++k) {
        const std::size_t height = k == 0 ? 64 : 128;
        const Environment image = environment_of_harmonics(given, 2 * height, height);
        const std::vector<Rgb> found = project_environment(image, 5);
        for (std::size_t i = 0; i < 25; ++i) error[k] = std::max(error[k], length(found[i] - given[i]));
    }
    EXPECT_LT(error[0], std::sqrt(3.0) * 0.004016);
    EXPECT_NEAR(error[0] / error[1], 4.0, 0.1);
}

TEST(HarmonicProjection, OfImagesHasTheirMeans) {
    // Each pixel is the mean over its solid angle, so that the whole image keeps the mean of the function.
    const std::vector<Rgb> given{{1, 2, 3}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    Environment image = environment_of_harmonics(given, 3, 2);
    image.up = normalized({1, 2, -3});
    const std::vector<Rgb> found = project_environment(image, 1);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[0][c], given[0][c], 1e-13);
}

TEST(SphericalHarmonics, RefuseWhatIsNoOrderAndNoRotation) {
    EXPECT_EQ(refusal([] { SphericalHarmonics(0); }), "order: wanted 1 to 32 bands, got 0");
    EXPECT_EQ(refusal([] { SphericalHarmonics(33); }), "order: wanted 1 to 32 bands, got 33");
    EXPECT_EQ(refusal([] { lobe_bands(1.0, 33); }), "order: wanted 1 to 32 bands, got 33");
    EXPECT_EQ(refusal([] { lobe_bands(-1.0, 3); }), "exponent: wanted a number of at least 0, got -1");
    EXPECT_EQ(SphericalHarmonics::order_of(25, "a"), 5);
    EXPECT_EQ(refusal([] { SphericalHarmonics::order_of(24, "a"); }),
              "a: wanted 1, 4, 9, 16, 25, ... coefficients, at most 1024, got 24");
    EXPECT_EQ(refusal([] { environment_of_harmonics({{1, 1, 1}}, 0, 4); }),
              "size: wanted at least one pixel, got 0 x 4");
    const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
    EXPECT_EQ(refusal([&] { HarmonicRotation({x, y, z}, 40); }), "order: wanted 1 to 32 bands, got 40");
    EXPECT_EQ(refusal([&] { HarmonicRotation({x, y, -z}, 5); }),
              "rotation: wanted a rotation matrix, got one that mirrors (determinant -1)");
    EXPECT_EQ(refusal([&] { HarmonicRotation({x, y, 2.0 * z}, 5); }),
              "rotation: wanted a rotation matrix, got rows that are not of unit length or not perpendicular (off by "
              "3)");
    EXPECT_EQ(refusal([&] { HarmonicRotation({x, y, {0, 0, std::nan("")}}, 5); }), "rotation: wanted finite numbers");
}

TEST(CapBands, AreThoseOfALobeOfExponentZeroOverAHemisphereAndOneOfAPoint) {
    double hemisphere[9], point[9];
    cap_bands(2.0 * pi, 9, hemisphere);
    cap_bands(0.0, 9, point);
    const std::vector<double> lobe = lobe_bands(0.0, 9);
    for (std::size_t l = 0; l < 9; ++l) {
        EXPECT_NEAR(hemisphere[l], lobe[l] / (2.0 * pi), 1e-12) << l;
        EXPECT_NEAR(point[l], 1.0, 1e-4) << l;
    }
}

}  // namespace
}  // namespace surflux
