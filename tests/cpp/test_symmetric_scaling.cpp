#include <gtest/gtest.h>

#include <cmath>

#include "surflux/radiosity/symmetric_scaling.h"

namespace surflux {
namespace {

ScalingProblem problem_of(const std::vector<std::vector<double>>& g, std::vector<double> totals,
                          std::vector<double> lost, double yield) {
    ScalingProblem out;
    out.totals = std::move(totals);
    out.lost = std::move(lost);
    out.yields.assign(out.totals.size(), yield);
    out.product = [g](const std::vector<double>& x, std::vector<double>& y) {
        y.assign(x.size(), 0.0);
        for (std::size_t i = 0; i < x.size(); ++i)
            for (std::size_t j = 0; j < x.size(); ++j) y[i] += g[i][j] * x[j];
    };
    return out;
}

const std::vector<std::vector<double>> g = {{0.1, 0.3, 0.4}, {0.3, 0.0, 0.5}, {0.4, 0.5, 0.2}};

TEST(SymmetricScaling, FindsTheDiagonalThatWasTakenAway) {
    for (double yield : {1.0, 0.5, 0.1}) {
        const std::vector<double> d = {0.7, 1.6, 1.1}, lost = {0.2, 0.3, 0.05};
        std::vector<double> totals(3, 0.0);
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) totals[i] += d[i] * g[i][j] * d[j];
            totals[i] += std::pow(d[i], yield) * lost[i];
        }
        const Scaling found = scale_symmetrically(problem_of(g, totals, lost, yield), 2.0, 1e-12);
        EXPECT_LE(found.residual, 1e-12);
        for (std::size_t i = 0; i < 3; ++i) {
            EXPECT_NEAR(found.scale[i], d[i], 1e-9) << yield;
            EXPECT_NEAR(found.lost_scale[i], std::pow(d[i], yield), 1e-9);
            EXPECT_NEAR(found.rows[i], 1.0, 1e-12);
        }
    }
}

TEST(SymmetricScaling, LossesThatHardlyYieldLeaveTheDifferenceToTheMatrix) {
    const std::vector<double> totals(3, 1.0), lost(3, 0.4);
    const auto shares = [&](double yield) {
        const Scaling found = scale_symmetrically(problem_of(g, totals, lost, yield), 2.0, 1e-10);
        EXPECT_LE(found.residual, 1e-10);
        return found.lost_scale;
    };
    const std::vector<double> as_much = shares(1.0), hardly = shares(0.01);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(hardly[i], 1.0, 0.01);
        EXPECT_LT(as_much[i], 0.98);  // rows make more than 1 to begin with
    }
}

TEST(SymmetricScaling, NoRowIsAboveItsTotalWhereTheBoundHoldsOthers) {
    // The first can give the second no more than it has.
    const Scaling found =
        scale_symmetrically(problem_of({{0.0, 0.9}, {0.9, 0.0}}, {1.0, 2.0}, {0.0, 0.0}, 1.0), 2.0, 1e-10);
    EXPECT_LE(found.residual, 1e-10);
    EXPECT_NEAR(found.rows[0], 1.0, 1e-9);
    EXPECT_NEAR(found.rows[1], 0.5, 1e-9);
    EXPECT_EQ(found.scale[1], 2.0);
}

TEST(SymmetricScaling, TwoRowsDoNotTakeTurnsAtTheBound) {
    // The bound cuts the step of one row short and not the other's: without a search along it, both end at .37.
    const double across = 0.99865, lost = 1.0 / 4096.0;
    const Scaling found =
        scale_symmetrically(problem_of({{0.0, across}, {across, 0.0}}, {1.0, 1.0}, {0.0, lost}, 0.1), 2.0, 1e-10);
    EXPECT_LE(found.residual, 1e-10);
    EXPECT_EQ(found.scale[0], 2.0);
    EXPECT_NEAR(found.rows[1], 1.0, 1e-9);
    EXPECT_NEAR(found.scale[1], (1.0 - lost * std::pow(found.scale[1], 0.1)) / (2.0 * across), 1e-9);
}

}  // namespace
}  // namespace surflux
