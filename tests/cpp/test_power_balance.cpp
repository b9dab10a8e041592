#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "surflux/solution/power_balance.h"

namespace surflux {
namespace {

double figure(const Figures& figures, const std::string& name) {
    for (const auto& [key, value] : figures)
        if (key == name) return value;
    ADD_FAILURE() << name;
    return 0.0;
}

// A surfel of area 2 and reflectance .5, of which half the hemisphere is open: B = .5 H, of that half escapes and the
// rest is its own H. So H = D + .25 H.
PowerBalance::Surfel half_open(const Rgb& direct, const Rgb& share_of_truth) {
    const Rgb irradiance = share_of_truth * (direct / 0.75);
    HemisphereLoss loss;
    loss.escape = 0.5;
    loss.variance = 1e-4;
    return {2.0, {0.5, 0.5, 0.5}, {}, direct, irradiance, loss};
}

TEST(PowerBalance, ClosesForTheRightSolution) {
    PowerBalance balance;
    balance.add(0, half_open({3, 3, 3}, {1, 1, 1}));
    const Figures found = balance.figures();
    EXPECT_NEAR(figure(found, "power_in"), 18.0, 1e-12);
    EXPECT_NEAR(figure(found, "power_absorbed"), 12.0, 1e-12);
    EXPECT_NEAR(figure(found, "power_escaped"), 6.0, 1e-12);
    EXPECT_NEAR(figure(found, "power_lost"), 0.0, 1e-12);
    // B = 6 in all channels, area 2: sqrt(1e-4 2 6^2).
    EXPECT_NEAR(figure(found, "power_lost_error"), std::sqrt(7.2e-3), 1e-12);
}

TEST(PowerBalance, ShowsWhatAnOpenPartLoses) {
    PowerBalance balance;
    balance.add(0, half_open({3, 3, 3}, {1, 1, 1}));
    balance.add(1, half_open({0.3, 0.3, 0.3}, {0.9, 0.9, 0.9}));
    const Figures found = balance.figures();
    EXPECT_NEAR(figure(found, "power_lost"), 0.1 * 1.8, 1e-12);
    EXPECT_NEAR(figure(found, "largest_part_lost"), 0.1, 1e-12);
    EXPECT_EQ(figure(found, "parts"), 2.0);
}

TEST(PowerBalance, OneChannelDoesNotMakeUpForAnother) {
    PowerBalance balance;
    balance.add(0, half_open({1, 1, 1}, {0.9, 1.1, 1.0}));
    EXPECT_NEAR(figure(balance.figures(), "power_lost"), 0.0, 1e-12);
    EXPECT_NEAR(figure(balance.figures(), "largest_part_lost"), 0.1, 1e-12);
}

}  // namespace
}  // namespace surflux
