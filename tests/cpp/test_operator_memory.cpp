// What an operator is taken to need, before its rows are shot.

#include <gtest/gtest.h>

#include <vector>

#include "refusal.h"
#include "surflux/transfer/operator_memory.h"

namespace surflux {
namespace {

// With 3 links for 10 rays.
ShotRows some_rows() {
    ShotRows of;
    of.rows.resize(100);
    of.rays = 1000;
    of.links.resize(300);
    return of;
}

TEST(OperatorMemory, RoomIsForAsManyAsFitAndNoMore) {
    const ShotRows of = some_rows();
    const double limit = 5e6;
    const std::size_t room = OperatorMemory(1000, 2, 64, 0, of, {}).room_for(limit, 64);
    ASSERT_GT(room, 0u);
    EXPECT_TRUE(OperatorMemory(1000, 2, 64, 0, of, std::vector<int>(room, 64)).fits(limit));
    EXPECT_FALSE(OperatorMemory(1000, 2, 64, 0, of, std::vector<int>(room + 2, 64)).fits(limit));
    EXPECT_EQ(OperatorMemory(1000, 2, 64, 0, of, {}).room_for(1e3, 64), 0u);
}

TEST(OperatorMemory, IsMoreThanTheOperatorItself) {
    const ShotRows of = some_rows();
    EXPECT_GT(OperatorMemory(0, 0, 64, 0, of, {}).bytes(),
              static_cast<double>(100 * sizeof(ShotRows::Row) + 300 * sizeof(ShotRows::Link)));
}

TEST(OperatorMemory, KnowsThatRowsNumberTheirLinksByThirtyTwoBits) {
    const ShotRows of = some_rows();
    const std::vector<int> rays(1 << 19, 1 << 16);  // 2^35 rays, .3 links each
    EXPECT_FALSE(OperatorMemory(0, 0, 64, 0, of, rays).fits(1e15));
    EXPECT_LT(OperatorMemory(0, 0, 64, 0, of, {}).room_for(1e15, 1 << 16), (1ull << 32) / (0.3 * (1 << 16)));
}

TEST(OperatorMemory, RefusesAFirstLevelWithoutRoom) {
    const ShotRows none;
    EXPECT_EQ(refusal([&] { OperatorMemory(0, 0, 64, 0, none, {512, 512}).require_room(1e4); }),
              "max_memory: the first level, of 2 places, takes 1 MB, and there are 0 MB for it; a larger radius or "
              "fewer rays take less");
}

}  // namespace
}  // namespace surflux
