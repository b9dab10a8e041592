#include <gtest/gtest.h>

#include <vector>

#include "surflux/core/place_order.h"
#include "surflux/core/random.h"

namespace surflux {
namespace {

TEST(PlaceOrder, PointsAtOnePlaceStandTogetherAscending) {
    // So many places that some share a hash of 32 bits (n^2 / 2^33: some ten), each at two points or three, and one
    // place written with either zero.
    const std::uint32_t places = 300000;
    std::vector<Vec3> points;
    for (std::uint32_t k = 0; k < 2 * places; ++k) {
        Random random(7, k % places);
        points.push_back({random.uniform(), random.uniform(), random.uniform()});
    }
    for (std::uint32_t k = 0; k < places; k += 2) points.push_back(points[k]);
    const auto zero = static_cast<std::uint32_t>(points.size());
    points.push_back({0.0, -0.0, 1.0});
    points.push_back({-0.0, 0.0, 1.0});

    const std::vector<std::uint32_t> order = place_order(points);
    std::vector<std::uint32_t> rank(points.size(), 0xffffffffu);
    for (std::uint32_t k = 0; k < order.size(); ++k) rank[order[k]] = k;
    for (std::uint32_t k = 0; k < places; ++k) {
        EXPECT_EQ(rank[places + k], rank[k] + 1);
        if (k % 2 == 0) {
            EXPECT_EQ(rank[2 * places + k / 2], rank[k] + 2);
        }
    }
    EXPECT_EQ(rank[zero + 1], rank[zero] + 1);
}

}  // namespace
}  // namespace surflux
