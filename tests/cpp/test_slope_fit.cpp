#include <gtest/gtest.h>

#include "surflux/core/vec.h"
#include "surflux/solution/slope_fit.h"

namespace surflux {
namespace {

TEST(SlopeFit, FindsASlopeButForItsStiffness) {
    SlopeFit<double> fit;
    SlopeFit<Rgb> of_colors;
    const double slope_x = 3.0, slope_y = -2.0;
    for (double x : {-1.0, 1.0})
        for (double y : {-1.0, 1.0}) {
            const double rise = slope_x * x + slope_y * y;
            fit.add(x, y, 0.5, rise);
            of_colors.add(x, y, 0.5, {rise, 0.0, 2.0 * rise});
        }
    double a = 0.0, b = 0.0;
    ASSERT_TRUE(fit.solve(a, b));
    EXPECT_NEAR(a, slope_x / 1.1, 1e-14);
    EXPECT_NEAR(b, slope_y / 1.1, 1e-14);
    Rgb u, v;
    ASSERT_TRUE(of_colors.solve(u, v));
    EXPECT_NEAR(u.x, a, 1e-14);
    EXPECT_EQ(u.y, 0.0);
    EXPECT_NEAR(v.z, 2.0 * b, 1e-14);
}

TEST(SlopeFit, TakesWhatWeighsMore) {
    // Two rises that no slope has both: the one that weighs a thousand times as much has its way.
    SlopeFit<double> fit;
    fit.add(1.0, 0.0, 1000.0, 5.0);
    fit.add(2.0, 0.0, 1.0, 0.0);
    double a = 0.0, b = 0.0;
    ASSERT_TRUE(fit.solve(a, b));
    EXPECT_NEAR(a, 5.0 / 1.05, 0.03);
}

TEST(SlopeFit, HasNoSlopeAcrossALineAndNoneFromNothing) {
    double a = 7.0, b = 7.0;
    EXPECT_FALSE(SlopeFit<double>().solve(a, b));
    EXPECT_EQ(a, 7.0);
    SlopeFit<double> fit;
    for (double x : {-2.0, -1.0, 1.0, 2.0}) fit.add(x, 0.0, 1.0, 4.0 * x);
    ASSERT_TRUE(fit.solve(a, b));
    EXPECT_NEAR(a, 4.0 / 1.05, 1e-14);
    EXPECT_EQ(b, 0.0);
}

}  // namespace
}  // namespace surflux
