#include "surflux/core/team.h"

#include <condition_variable>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

using namespace surflux;

namespace {

// Threads that stand for processes: what one gives waits for that of all others.
class Meeting {
public:
    explicit Meeting(std::size_t size) : given_(size) {}

    Team team(std::size_t rank) {
        return {rank, given_.size(), [this, rank](const std::string&, const Team::Mine& mine) {
                    std::string own = mine();
                    std::unique_lock<std::mutex> lock(mutex_);
                    given_[rank] = std::move(own);
                    const std::size_t round = round_;
                    if (++here_ == given_.size()) {
                        log.push_back(given_);
                        here_ = 0, ++round_;
                        all_here_.notify_all();
                    }
                    all_here_.wait(lock, [&] { return round_ != round; });
                    return log[round];
                }};
    }

    std::vector<std::vector<std::string>> log;

private:
    std::vector<std::string> given_;
    std::mutex mutex_;
    std::condition_variable all_here_;
    std::size_t here_ = 0, round_ = 0;
};

// Squares of 0 to count - 1, of which `made` says how many this process made itself.
std::vector<std::uint64_t> squares(const Team& team, std::size_t count, std::size_t& made, std::uint64_t digest = 7) {
    std::vector<std::uint64_t> out(count, 0);
    std::vector<char> by_me(count, 0);
    shared_blocks(
        team, "squares", [&] { return digest; }, count, 3,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) out[k] = k * k, by_me[k] = 1;
        },
        [&](std::size_t begin, std::size_t end, Packed& to) { to.add(out.data() + begin, end - begin); },
        [&](std::size_t begin, std::size_t end, Unpacking& from) { from.take(out.data() + begin, end - begin); }, {});
    made = 0;
    for (const char mine : by_me) made += mine != 0;
    return out;
}

TEST(Team, ProcessesMakeEachBlockOnceAndKnowAll) {
    std::size_t made = 0;
    for (const std::size_t count : {0, 1, 2, 3, 10, 100}) {
        const std::vector<std::uint64_t> alone = squares({}, count, made);
        EXPECT_EQ(made, count);
        for (const std::size_t size : {1, 2, 3, 4, 40}) {
            Meeting meeting(size);
            std::vector<std::vector<std::uint64_t>> found(size);
            std::vector<std::size_t> made_by(size);
            std::vector<std::thread> threads;
            for (std::size_t rank = 0; rank < size; ++rank)
                threads.emplace_back([&, rank] { found[rank] = squares(meeting.team(rank), count, made_by[rank]); });
            for (std::thread& thread : threads) thread.join();
            std::size_t all = 0;
            for (std::size_t rank = 0; rank < size; ++rank) {
                EXPECT_EQ(found[rank], alone) << size << " processes, rank " << rank;
                EXPECT_LE(made_by[rank], (count + 3 * size - 1) / (3 * size) * 3);
                all += made_by[rank];
            }
            EXPECT_EQ(all, count);
        }
    }
}

TEST(Team, ResultsOfAnotherNumberOfProcessesAreTakenAsTheyAre) {
    Meeting meeting(1);
    std::size_t made = 0;
    const std::vector<std::uint64_t> alone = squares(meeting.team(0), 10, made);
    const std::vector<std::string> known = meeting.log[0];
    const Team later{2, 3, [&](const std::string&, const Team::Mine&) { return known; }};
    EXPECT_EQ(squares(later, 10, made), alone);
    EXPECT_EQ(made, 0u);
}

// What `text` throws is what `all` make of a pass of ten.
std::string fault_of(std::vector<std::string> all, std::uint64_t digest = 7, std::size_t count = 10) {
    std::size_t made = 0;
    const Team team{0, 1, [&](const std::string&, const Team::Mine&) { return all; }};
    try {
        squares(team, count, made, digest);
    } catch (const DeviceError& error) {
        return error.what();
    }
    return "";
}

TEST(Team, ProcessesThatDisagreeAreRefused) {
    Meeting meeting(1);
    std::size_t made = 0;
    squares(meeting.team(0), 10, made);
    const std::vector<std::string> known = meeting.log[0];
    EXPECT_EQ(fault_of(known), "");
    const std::string differ =
        "squares: process 0 has come to other results; all must have the same scene, options, surflux and kind of "
        "processor";
    EXPECT_EQ(fault_of(known, 8), differ);
    EXPECT_EQ(fault_of(known, 7, 11), differ);
    EXPECT_EQ(fault_of({known[0].substr(0, 90)}), "what another process sent is cut off");
    EXPECT_EQ(fault_of({known[0].substr(0, 4)}), "what another process sent is cut off");
    EXPECT_EQ(fault_of({known[0] + "x"}), "another process sent more than was wanted");
}

TEST(Team, DigestsTellValuesAndTheirOrderApart) {
    const auto of = [](double a, double b) {
        Digest digest;
        digest.add(a), digest.add(b);
        return digest.value();
    };
    EXPECT_EQ(of(1.0, 2.0), of(1.0, 2.0));
    EXPECT_NE(of(1.0, 2.0), of(2.0, 1.0));
    EXPECT_NE(of(1.0, 2.0), of(1.0, 2.0 + 0x1p-51));
    EXPECT_NE(of(0.0, 0.0), of(0.0, -0.0));
}

}  // namespace
