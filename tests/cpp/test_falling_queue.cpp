#include <gtest/gtest.h>

#include <cmath>

#include "surflux/core/random.h"
#include "surflux/neighbors/falling_queue.h"

using namespace surflux;

// Against a search through all items, with keys that fall by chance, below 0 too, and many that are equal.
TEST(FallingQueue, TakesTheLargestKeyAndOfEqualOnesTheWinner) {
    Random random(3, 0);
    std::vector<double> keys(500);
    for (double& key : keys) key = std::floor(8.0 * random.uniform()) * 0.125 + (random.uniform() < 0.1 ? 1e-30 : 0.0);
    const auto wins = [](std::uint32_t i, std::uint32_t j) { return i > j; };
    FallingQueue queue(keys, wins);
    std::vector<bool> gone(keys.size(), false);
    for (std::size_t taken = 0; taken < keys.size(); ++taken) {
        std::uint32_t best = 0;
        while (gone[best]) ++best;
        for (std::uint32_t i = best + 1; i < keys.size(); ++i)
            if (!gone[i] && keys[i] >= keys[best]) best = i;
        ASSERT_EQ(queue.take(), best) << "after " << taken;
        gone[best] = true;
        for (int k = 0; k < 20; ++k) {
            const auto i = static_cast<std::size_t>(random.uniform() * 500.0);
            keys[i] -= random.uniform() < 0.5 ? 0.125 : 0.3 * random.uniform();
        }
    }
}
