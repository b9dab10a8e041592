#include <gtest/gtest.h>

#include "surflux/core/thread_scratch.h"

namespace surflux {
namespace {

TEST(ThreadScratch, KeepsWhatMostCallsNeedAndGivesBackTheRest) {
    std::vector<double> kept;
    const auto hold = [&kept](std::size_t count) {
        const ThreadScratch scratch(kept);
        EXPECT_TRUE(kept.empty());
        kept.resize(count);
    };
    hold(100);
    EXPECT_GE(kept.capacity(), 100u);
    const double* before = kept.data();
    hold(50);
    EXPECT_EQ(kept.data(), before);
    hold(1000000);
    EXPECT_LE(kept.capacity() * sizeof(double), ThreadScratch<double>::most_kept);
}

}  // namespace
}  // namespace surflux
