#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"

namespace surflux {
namespace {

double term(std::size_t i) { return std::sin(static_cast<double>(i)) * std::pow(10.0, static_cast<double>(i % 17)); }

TEST(ParallelSum, IsThatOfTheBlocksInTheirOrder) {
    // Terms of very different size: any other order, or other blocks, would round to another sum.
    const std::size_t count = 10007, grain = 64;
    double expected = 0.0, in_one_go = 0.0;
    for (std::size_t begin = 0; begin < count; begin += grain) {
        double block = 0.0;
        for (std::size_t i = begin; i < std::min(count, begin + grain); ++i) block += term(i), in_one_go += term(i);
        expected += block;
    }
    ASSERT_NE(expected, in_one_go);
    for (int threads : {1, 2, 4}) {
        const ThreadLimit limit(threads);
        const auto add = [](std::size_t i, double& sum) { sum += term(i); };
        EXPECT_EQ(parallel_sum<double>(count, grain, add), expected) << threads << " threads";
    }
}

TEST(ParallelSum, TakesWhateverAddsUp) {
    struct Tally {
        std::size_t even = 0, odd = 0;
        void operator+=(const Tally& other) { even += other.even, odd += other.odd; }
    };
    const auto add = [](std::size_t i, Tally& tally) { (i % 2 == 0 ? tally.even : tally.odd) += i; };
    for (std::size_t grain : {0u, 1u, 7u, 1000u}) {
        const Tally found = parallel_sum<Tally>(101, grain, add);
        EXPECT_EQ(found.even, 2550u);
        EXPECT_EQ(found.odd, 2500u);
        EXPECT_EQ(parallel_sum<Tally>(0, grain, add).even, 0u);
    }
}

}  // namespace
}  // namespace surflux
