#include <gtest/gtest.h>

#include <set>

#include "surflux/core/sampling.h"

namespace surflux {
namespace {

TEST(EvenPoints, FillLinesAndTheTwoSquaresEvenly) {
    // A net in base 2: of 64 points one stands in each 64th of every coordinate, and one in each cell of 8 x 8 of the
    // squares (0, 1) and (2, 3), whatever the seed. That is why 64 rays are good for 1/64, not 1/8, of a light's edge.
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
        EvenPoints even(4, seed, 3 * seed);
        std::set<int> along[4], cells[2];
        for (int k = 0; k < 64; ++k) {
            const double* u = even.next();
            for (int d = 0; d < 4; ++d) {
                ASSERT_GT(u[d], 0.0);
                ASSERT_LT(u[d], 1.0);
                along[d].insert(int(64 * u[d]));
            }
            for (int pair = 0; pair < 2; ++pair)
                cells[pair].insert(8 * int(8 * u[2 * pair]) + int(8 * u[2 * pair + 1]));
        }
        for (const auto& found : along) EXPECT_EQ(found.size(), 64u) << seed;
        for (const auto& found : cells) EXPECT_EQ(found.size(), 64u) << seed;
    }
}

TEST(EvenPoints, AreUnbiasedOverSeedsAndDifferByStream) {
    // The first point alone is uniform: the mean of 4000 is .5 +- sqrt(1 / 12 / 4000) = .0046, four of them allowed.
    double sum[4] = {};
    for (std::uint64_t stream = 0; stream < 4000; ++stream) {
        EvenPoints even(4, 7, stream);
        const double* u = even.next();
        for (int d = 0; d < 4; ++d) sum[d] += u[d] / 4000;
    }
    for (double mean : sum) EXPECT_NEAR(mean, 0.5, 4 * 0.0046);
}

TEST(EvenPoints, LeaveUnusedCoordinatesAlone) {
    EvenPoints even(2, 0, 0);
    even.next();
    const double* u = even.next();
    EXPECT_GT(u[1], 0.0);
    EXPECT_EQ(u[2], 0.0);
    EXPECT_EQ(u[3], 0.0);
}

}  // namespace
}  // namespace surflux
