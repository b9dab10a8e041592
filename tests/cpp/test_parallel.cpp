#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <future>
#include <mutex>
#include <set>
#include <thread>

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

TEST(ParallelSort, IsThatOfTheStandardLibrary) {
    for (const std::size_t count : {0u, 1u, 63u, 64u, 65u, 10007u}) {
        std::vector<std::uint64_t> values(count);
        for (std::size_t i = 0; i < count; ++i) values[i] = (i * 0x9e3779b97f4a7c15ull) >> 7;
        std::vector<std::uint64_t> expected = values;
        std::sort(expected.begin(), expected.end());
        parallel_sort(values, std::less<>());
        EXPECT_EQ(values, expected);
    }
}

TEST(ParallelScatter, IsThatOfFourBlocksInTheirOrderHoweverOftenItReports) {
    // More than are added between two reports, of very different size, to 3 places in turn.
    const std::size_t count = (std::size_t{1} << 20) + 5;
    std::vector<double> expected(3, 0.0);
    for (std::size_t block = 0; block < 4; ++block) {
        std::vector<double> sums(3, 0.0);
        for (std::size_t i = block * count / 4; i < (block + 1) * count / 4; ++i) sums[i % 3] += term(i);
        for (std::size_t k = 0; k < 3; ++k) expected[k] += sums[k];
    }
    const auto add = [](std::size_t i, std::vector<double>& sums) { sums[i % 3] += term(i); };
    std::size_t reports = 0;
    const Progress progress = [&](std::size_t done, std::size_t total) {
        EXPECT_LE(done, total);
        return ++reports > 0;
    };
    for (int threads : {1, 4}) {
        const ThreadLimit limit(threads);
        std::vector<double> found(3, 7.0);
        parallel_scatter(count, found, add);
        EXPECT_EQ(found, expected);
        parallel_scatter(count, found, add, progress);
        EXPECT_EQ(found, expected);
    }
    EXPECT_EQ(reports, 4u);
    std::vector<double> nothing(3, 7.0);
    parallel_scatter(0, nothing, add, progress);
    EXPECT_EQ(nothing, std::vector<double>(3, 0.0));
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

// How many of `count` blocks were under way at one time: each waits for the others, not for ever.
int blocks_at_once(int count) {
    std::atomic<int> arrived{0};
    parallel_for(static_cast<std::size_t>(count), 1, [&](std::size_t) {
        ++arrived;
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20 / count);
        while (arrived < count && std::chrono::steady_clock::now() < end) std::this_thread::yield();
        if (arrived < count) --arrived;
    });
    return arrived;
}

TEST(ThreadLimit, IsThatOfTheThreadThatSetIt) {
    const int all = thread_count();
    std::promise<void> limited, done;
    std::size_t threads_of_one = 0;
    std::thread one([&] {
        const ThreadLimit limit(1);
        limited.set_value();
        done.get_future().wait();  // its limit stands before and after that of the other
        std::mutex mutex;
        std::set<std::thread::id> ids;
        parallel_for(200, 1, [&](std::size_t) {
            const std::lock_guard lock(mutex);
            ids.insert(std::this_thread::get_id());
        });
        threads_of_one = ids.size();
    });
    limited.get_future().wait();
    EXPECT_EQ(thread_count(), all);
    {
        const ThreadLimit limit(3);
        EXPECT_EQ(thread_count(), 3);
        EXPECT_EQ(blocks_at_once(3), 3);
        {
            const ThreadLimit within(5);  // does not lift the one around it
            EXPECT_EQ(thread_count(), 3);
            const ThreadLimit no_other(0);
            EXPECT_EQ(thread_count(), 3);
        }
        int of_other = 0, of_helper = 0;
        std::thread([&] { of_other = thread_count(); }).join();
        std::thread(with_this_limit([&] { of_helper = thread_count(); })).join();
        EXPECT_EQ(of_helper, 3);
        EXPECT_EQ(of_other, all);
    }
    EXPECT_EQ(thread_count(), all);
    done.set_value();
    one.join();
    EXPECT_EQ(threads_of_one, 1u);
    EXPECT_EQ(thread_count(), all);
}

TEST(ThreadLimit, StandsAlsoWhereLimitsEndInAnotherOrder) {
    const int all = thread_count(), many = all + 2;
    std::promise<void> begun, end;
    std::thread other([&] {
        const ThreadLimit limit(many);
        begun.set_value();
        end.get_future().wait();
    });
    begun.get_future().wait();
    {
        const ThreadLimit limit(many + 1);
        end.set_value();
        other.join();
        EXPECT_EQ(blocks_at_once(many + 1), many + 1);
    }
    EXPECT_EQ(thread_count(), all);
    std::thread([&] { EXPECT_EQ(thread_count(), all); }).join();
}

}  // namespace
}  // namespace surflux
