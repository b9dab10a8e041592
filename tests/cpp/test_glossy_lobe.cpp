#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "surflux/core/random.h"
#include "surflux/lights/glossy_lobe.h"
#include "surflux/scene/gloss.h"

namespace surflux {
namespace {

const Vec3 up{0, 0, 1};

TEST(GlossyLobe, SendsItsReflectancesOfAnEvenSky) {
    // In z alone: the integral of 2 pi value over [0, 1] by the midpoint rule of 10000 steps, to 1e-6.
    const GlossyLobe lobe(up, up, {0.2, 0.3, 0.4}, {0.5, 0.1, 0.0}, 12.5);
    Rgb sum;
    double density = 0.0;
    const int steps = 10000;
    for (int k = 0; k < steps; ++k) {
        const double z = (k + 0.5) / steps, r = std::sqrt(1.0 - z * z);
        sum += (2.0 * pi / steps) * lobe.value({0, r, z});
        density += 2.0 * pi / steps * lobe.density({0, r, z});
    }
    EXPECT_NEAR(sum.x, 0.7, 1e-6);
    EXPECT_NEAR(sum.y, 0.4, 1e-6);
    EXPECT_NEAR(sum.z, 0.4, 1e-6);
    EXPECT_NEAR(density, 1.0, 1e-6);
    EXPECT_TRUE(lobe.value({0, 0.6, -0.8}) == Rgb{});
}

TEST(GlossyLobe, DrawsWhatItsDensitySays) {
    // Means of functions over draws are their integrals times the density, here by drawing evenly over the sphere: for
    // 40000 of each within 5 standard errors of both.
    const Vec3 normal = normalized({0.2, -0.4, 0.9}), out = normalized({1.0, 0.3, 0.4});
    const GlossyLobe lobe(normal, out, {0.2, 0.2, 0.2}, {0.3, 0.3, 0.3}, 7.0);
    const auto functions = [](const Vec3& d, double (&f)[4]) {
        f[0] = 1.0, f[1] = d.x, f[2] = d.y * d.z, f[3] = d.z > 0.3 ? 1.0 : 0.0;
    };
    double drawn[4] = {}, drawn_square[4] = {}, even[4] = {}, even_square[4] = {};
    const int n = 40000;
    for (int k = 0; k < n; ++k) {
        Random random(1, static_cast<std::uint64_t>(k));
        const double u = random.uniform(), v = random.uniform(), choice = random.uniform();
        const double z = 1.0 - 2.0 * random.uniform(), phi = 2.0 * pi * random.uniform(), r = std::sqrt(1.0 - z * z);
        double f[4];
        functions(lobe.sample(u, v, choice), f);
        for (int i = 0; i < 4; ++i) drawn[i] += f[i] / n, drawn_square[i] += f[i] * f[i] / n;
        const Vec3 d{r * std::cos(phi), r * std::sin(phi), z};
        functions(d, f);
        for (int i = 0; i < 4; ++i) {
            const double weighed = 4.0 * pi * lobe.density(d) * f[i];
            even[i] += weighed / n, even_square[i] += weighed * weighed / n;
        }
    }
    for (int i = 0; i < 4; ++i) {
        const double variance = drawn_square[i] - drawn[i] * drawn[i] + even_square[i] - even[i] * even[i];
        EXPECT_NEAR(drawn[i], even[i], 5.0 * std::sqrt(variance / n)) << i;
        EXPECT_LT(std::sqrt(variance / n), 0.02);
    }
}

TEST(Gloss, OfNothingSpecularTakesNoMemory) {
    EXPECT_TRUE(Gloss(std::vector<Rgb>(5), std::vector<double>(5, Gloss::usual_exponent)).empty());
    const Gloss exponents(std::vector<Rgb>(2), {1.0, 2.0});
    EXPECT_FALSE(exponents.empty());
    EXPECT_FALSE(exponents.has_specular());
    EXPECT_EQ(exponents.exponent(1), 2.0);
}

TEST(Gloss, IsChosenAndPutTogether) {
    const Gloss one(std::vector<Rgb>{{0.1, 0.1, 0.1}, {0.2, 0.2, 0.2}}, {});
    Gloss all;
    all.append(Gloss(), 0, 3);
    EXPECT_TRUE(all.empty());
    all.append(one, 3, 2);
    all.append(Gloss(std::vector<Rgb>(1), {4.0}), 5, 1);
    EXPECT_EQ(all.specular(2).x, 0.0);
    EXPECT_EQ(all.specular(4).x, 0.2);
    EXPECT_EQ(all.specular(5).x, 0.0);
    EXPECT_EQ(all.exponent(4), Gloss::usual_exponent);
    EXPECT_EQ(all.exponent(5), 4.0);
    const Gloss some = all.select({5, 3});
    EXPECT_EQ(some.exponent(0), 4.0);
    EXPECT_EQ(some.specular(1).x, 0.1);
    EXPECT_TRUE(all.select({0, 1}).empty());
}

}  // namespace
}  // namespace surflux
