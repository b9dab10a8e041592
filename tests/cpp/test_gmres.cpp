#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "refusal.h"
#include "surflux/core/sampling.h"
#include "surflux/solution/conjugate_gradients.h"
#include "surflux/solution/gmres.h"

namespace surflux {
namespace {

// A dense matrix, the same for all channels.
struct Dense {
    std::size_t n;
    std::vector<double> a;

    std::vector<double> times(const std::vector<double>& x, std::size_t channels) const {
        std::vector<double> out(x.size(), 0.0);
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < n; ++j)
                for (std::size_t c = 0; c < channels; ++c) out[i * channels + c] += a[i * n + j] * x[j * channels + c];
        return out;
    }
    LinearOperator on(std::size_t channels, int* calls = nullptr) const {
        return [this, channels, calls](const std::vector<double>& x, std::vector<double>& out) {
            out = times(x, channels);
            if (calls) ++*calls;
        };
    }
};

// I - rho P with rows of P that sum to 1 and no symmetry: what bounces of light make.
Dense of_light(std::size_t n, double rho) {
    Dense out{n, std::vector<double>(n * n)};
    Random random(7, 0);
    for (std::size_t i = 0; i < n; ++i) {
        double sum = 0.0;
        for (std::size_t j = 0; j < n; ++j) sum += out.a[i * n + j] = std::pow(random.uniform(), 8.0);
        for (std::size_t j = 0; j < n; ++j) out.a[i * n + j] *= -rho / sum;
        out.a[i * n + i] += 1.0;
    }
    return out;
}

std::vector<double> random_values(std::size_t count, std::uint64_t seed) {
    Random random(seed, 1);
    std::vector<double> out(count);
    for (double& value : out) value = random.uniform() - 0.3;
    return out;
}

// |b - A x| / |b| of one channel, not as the solver has it.
double residual_of(const Dense& m, const std::vector<double>& x, const std::vector<double>& b, std::size_t channels,
                   std::size_t c) {
    const std::vector<double> product = m.times(x, channels);
    double squared = 0.0, size = 0.0;
    for (std::size_t k = c; k < b.size(); k += channels) {
        squared += (b[k] - product[k]) * (b[k] - product[k]);
        size += b[k] * b[k];
    }
    return std::sqrt(squared / size);
}

TEST(Gmres, SolvesWhatIsNotSymmetric) {
    for (double rho : {0.5, 0.9, 0.999}) {
        const Dense m = of_light(60, rho);
        const std::vector<double> wanted = random_values(60, 1), b = m.times(wanted, 1);
        std::vector<double> x;
        const LinearReport report = gmres(m.on(1), b, 1, 1e-12, 400, x);
        EXPECT_LE(report.residual, 1e-12);
        for (std::size_t k = 0; k < x.size(); ++k) EXPECT_NEAR(x[k], wanted[k], 1e-8) << rho;
    }
    // A rotation: conjugate gradients and all fixed-point iterations fail on it, for it has no symmetric part.
    const Dense turn{2, {0.0, -1.0, 1.0, 0.0}};
    std::vector<double> x;
    EXPECT_LE(gmres(turn.on(1), {1.0, 2.0}, 1, 1e-12, 20, x).residual, 1e-12);
    EXPECT_NEAR(x[0], 2.0, 1e-11);
    EXPECT_NEAR(x[1], -1.0, 1e-11);
}

TEST(Gmres, WhatItReportsIsTheTrueResidual) {
    // A residual carried along by recurrences would drift from b - A x: here it is computed anew. It needs more than
    // one restart, too.
    const Dense m = of_light(200, 0.9999);
    const std::vector<double> b = random_values(200, 2);
    for (double tolerance : {1e-2, 1e-6, 1e-10}) {
        std::vector<double> x;
        int calls = 0;
        const LinearReport report = gmres(m.on(1, &calls), b, 1, tolerance, 500, x);
        EXPECT_LE(report.residual, tolerance);
        EXPECT_NEAR(residual_of(m, x, b, 1, 0), report.residual, 1e-12);
        EXPECT_EQ(report.applications, calls);
    }
}

TEST(Gmres, RestartsDoNotStopIt) {
    // Eigenvalues spread evenly over four decades: not to be done in the 30 directions that are kept.
    const std::size_t n = 120;
    Dense m{n, std::vector<double>(n * n, 0.0)};
    for (std::size_t k = 0; k < n; ++k) m.a[k * n + k] = 1.0 + 0.5 * static_cast<double>(k);
    const std::vector<double> b = random_values(n, 3);
    std::vector<double> x;
    const LinearReport report = gmres(m.on(1), b, 1, 1e-10, 2000, x);
    EXPECT_LE(report.residual, 1e-10);
    EXPECT_GT(report.applications, 32);
}

TEST(Gmres, WhereNothingComesInThereIsNothing) {
    const Dense m = of_light(20, 0.9);
    std::vector<double> x(20, 1e-4);  // below the tolerance, in whatever units
    gmres(m.on(1), std::vector<double>(20, 0.0), 1, 1e-3, 100, x);
    EXPECT_EQ(x, std::vector<double>(20, 0.0));
}

TEST(Gmres, NoConnectedPartIsLostBesideABrighterOne) {
    // Two rooms that see nothing of each other, one 1e9 times as bright. A norm over both would call the dark one
    // solved before it began.
    const std::size_t n = 40;
    const Dense one = of_light(n, 0.99);
    Dense both{2 * n, std::vector<double>(4 * n * n, 0.0)};
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) both.a[2 * i * n + j] = both.a[2 * (i + n) * n + j + n] = one.a[i * n + j];
    std::vector<double> b = random_values(2 * n, 4), x, alone;
    std::vector<std::uint32_t> part(2 * n, 0);
    for (std::size_t k = n; k < 2 * n; ++k) b[k] *= 1e9, part[k] = 1;
    const std::vector<double> dark(b.begin(), b.begin() + n);
    EXPECT_LE(gmres(both.on(1), b, LinearSystems(1, part), 1e-6, 300, x).residual, 1e-6);
    gmres(one.on(1), dark, 1, 1e-6, 300, alone);
    EXPECT_LE(residual_of(one, {x.begin(), x.begin() + n}, dark, 1, 0), 1e-6 * (1 + 1e-6));
    for (std::size_t k = 0; k < n; ++k) EXPECT_NEAR(x[k], alone[k], 2e-4 * std::abs(alone[k])) << k;
}

TEST(Gmres, NoChannelIsLostBesideABrighterOne) {
    // Sizes 1e12 apart. A norm over all channels would call the dark one solved before it began.
    const std::size_t channels = 3;
    const Dense m = of_light(40, 0.95);
    const double sizes[channels] = {1e9, 1.0, 1e-3};
    std::vector<double> b = random_values(40 * channels, 4), x;
    for (std::size_t k = 0; k < b.size(); ++k) b[k] *= sizes[k % channels];
    const LinearReport report = gmres(m.on(channels), b, channels, 1e-9, 300, x);
    EXPECT_LE(report.residual, 1e-9);
    for (std::size_t c = 0; c < channels; ++c) EXPECT_LE(residual_of(m, x, b, channels, c), 1e-9 * (1 + 1e-6)) << c;
}

TEST(Gmres, AChannelWithoutLightStaysDark) {
    const Dense m = of_light(20, 0.9);
    std::vector<double> b = random_values(40, 5), x;
    for (std::size_t k = 1; k < b.size(); k += 2) b[k] = 0.0;
    EXPECT_LE(gmres(m.on(2), b, 2, 1e-8, 100, x).residual, 1e-8);
    for (std::size_t k = 1; k < x.size(); k += 2) EXPECT_EQ(x[k], 0.0);

    x.clear();
    const LinearReport nothing = gmres(m.on(2), std::vector<double>(40, 0.0), 2, 1e-8, 100, x);
    EXPECT_EQ(nothing.residual, 0.0);
    EXPECT_EQ(nothing.applications, 1);
    EXPECT_EQ(x, std::vector<double>(40, 0.0));
}

TEST(Gmres, BeginsWhereItStood) {
    const Dense m = of_light(100, 0.99);
    const std::vector<double> wanted = random_values(100, 6), b = m.times(wanted, 1);
    std::vector<double> x = wanted, cold;
    EXPECT_EQ(gmres(m.on(1), b, 1, 1e-10, 100, x).applications, 1);
    EXPECT_EQ(x, wanted);
    // From nearby it takes fewer steps than from nothing.
    for (double& value : x) value *= 1.0 + 1e-4;
    EXPECT_LT(gmres(m.on(1), b, 1, 1e-6, 100, x).applications, gmres(m.on(1), b, 1, 1e-6, 100, cold).applications);
}

TEST(Gmres, StopsWhereTheOperatorIsSingular) {
    // A x = b has no solution: the residual says so, and nothing runs on or turns into NaN.
    const Dense nothing{3, std::vector<double>(9, 0.0)};
    std::vector<double> x;
    const LinearReport none = gmres(nothing.on(1), {1.0, 2.0, 3.0}, 1, 1e-6, 50, x);
    EXPECT_NEAR(none.residual, 1.0, 1e-12);
    EXPECT_LE(none.applications, 50);
    for (double value : x) EXPECT_TRUE(std::isfinite(value));

    const Dense flat{2, {1.0, 1.0, 1.0, 1.0}};
    x.clear();
    const LinearReport half = gmres(flat.on(1), {1.0, 0.0}, 1, 1e-6, 50, x);
    EXPECT_LE(half.applications, 50);
    EXPECT_NEAR(half.residual, std::sqrt(0.5), 1e-6);  // the nearest is (1/2, 1/2)
    for (double value : x) EXPECT_TRUE(std::isfinite(value));

    // One that has a solution all the same.
    x.clear();
    EXPECT_LE(gmres(flat.on(1), {1.0, 1.0}, 1, 1e-9, 50, x).residual, 1e-9);
}

TEST(Gmres, NeverAppliesTheOperatorMoreOftenThanItMay) {
    const Dense m = of_light(300, 0.999999);
    const std::vector<double> b = random_values(300, 8);
    for (int most : {1, 2, 3, 10, 31, 33, 40}) {
        std::vector<double> x;
        int calls = 0;
        const LinearReport report = gmres(m.on(1, &calls), b, 1, 1e-15, most, x);
        EXPECT_LE(calls, most);
        EXPECT_EQ(report.applications, calls);
        EXPECT_NEAR(report.residual, residual_of(m, x, b, 1, 0), 1e-12) << most;
    }
}

TEST(Gmres, RefusesWhatIsBeyondFloat64) {
    const Dense m = of_light(4, 0.5);
    for (double value : {1e200, std::numeric_limits<double>::infinity(), std::nan("")}) {
        std::vector<double> x;
        const std::string said = refusal([&] { gmres(m.on(1), std::vector<double>(4, value), 1, 1e-6, 50, x); });
        EXPECT_EQ(said.find("scene: "), 0u) << said;
        EXPECT_NE(said.find("too strong"), std::string::npos) << said;
    }
}

TEST(Gmres, RefusesAnOperatorThatIsNotFinite) {
    // Whatever the operator makes of the start, or of the first direction alone: no NaN passes as a small residual.
    for (double value : {std::nan(""), std::numeric_limits<double>::infinity()})
        for (bool at_zero : {true, false}) {
            const LinearOperator broken = [&](const std::vector<double>& in, std::vector<double>& out) {
                out = in;
                if (at_zero || in[0] != 0.0) out[0] = value;
            };
            std::vector<double> x;
            EXPECT_NE(refusal([&] { gmres(broken, {1.0, 1.0}, 1, 1e-6, 50, x); }).find("too strong"), std::string::npos)
                << value << " " << at_zero;
            x.clear();
            EXPECT_NE(refusal([&] { conjugate_gradients(broken, {1.0, 1.0}, 1, 1e-6, 50, x); }).find("too strong"),
                      std::string::npos)
                << value << " " << at_zero;
        }
}

}  // namespace
}  // namespace surflux
