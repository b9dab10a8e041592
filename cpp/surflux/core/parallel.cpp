#include "surflux/core/parallel.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/version.h>

namespace surflux {

namespace tbb = oneapi::tbb;

namespace {

using Arena = std::shared_ptr<tbb::task_arena>;

// Where the loops of a thread run that has a limit. Loops within loops find themselves in it already.
thread_local Arena limited;

}  // namespace

void within_limit(const std::function<void()>& work) {
    const Arena arena = limited;  // which another limit within the work may replace for a while
    if (arena)
        arena->execute(work);
    else
        work();
}

void parallel_blocks(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) {
    if (count == 0) return;
    grain = std::max<std::size_t>(grain, 1);
    const std::size_t blocks = (count + grain - 1) / grain;
    within_limit([&] {
        tbb::parallel_for(std::size_t{0}, blocks,
                          [&](std::size_t block) { body(block * grain, std::min(count, (block + 1) * grain)); });
    });
}

void parallel_blocks(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body,
                     const Progress& progress) {
    if (!progress) return parallel_blocks(count, grain, body);
    using Clock = std::chrono::steady_clock;
    grain = std::max<std::size_t>(grain, 1);
    // A batch of blocks is one parallel region; its size follows the clock so that a report comes about every 0.1 s.
    std::size_t batch = grain * 16;
    for (std::size_t done = 0; done < count;) {
        const std::size_t size = std::min(batch, count - done);
        const auto start = Clock::now();
        parallel_blocks(size, grain, [&](std::size_t begin, std::size_t end) { body(done + begin, done + end); });
        done += size;
        report(progress, done, count);
        const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
        if (seconds < 0.05) batch *= 2;
        if (seconds > 0.2 && batch > grain) batch = std::max(grain, batch / 2 / grain * grain);
    }
}

struct ThreadLimit::Impl {
    explicit Impl(int threads) {
        const int count = limited ? std::min(threads, thread_count()) : threads;
        // TBB makes no more threads than there are cores unless it is told: a limit above that counts, too, so that a
        // machine of two cores can show that four threads give the same.
        if (count > tbb::info::default_concurrency())
            more.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count));
        around = std::exchange(limited, std::make_shared<tbb::task_arena>(count));
    }
    ~Impl() { limited = std::move(around); }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    std::optional<tbb::global_control> more;
    Arena around;
};

ThreadLimit::ThreadLimit(int threads) {
    if (threads > 0) impl_ = std::make_unique<Impl>(threads);
}

ThreadLimit::~ThreadLimit() = default;

int thread_count() {
    if (limited) return limited->max_concurrency();
    const std::size_t allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    return std::min(tbb::info::default_concurrency(), static_cast<int>(allowed));
}

std::function<void()> with_this_limit(std::function<void()> work) {
    return [arena = limited, work = std::move(work)] {
        const Arena before = std::exchange(limited, arena);
        struct Restore {
            const Arena& before;
            ~Restore() { limited = before; }
        } const restore{before};
        work();
    };
}

std::string tbb_version() { return TBB_runtime_version(); }

}  // namespace surflux
