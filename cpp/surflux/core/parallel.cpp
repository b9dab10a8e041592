#include "surflux/core/parallel.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <utility>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/version.h>

namespace surflux {

namespace tbb = oneapi::tbb;

namespace {

// TBB has no room for more threads than cores unless it is made: a limit above that counts, too, so that a machine of
// two cores can show that four threads give the same. Empty while no such limit stands.
std::mutex wide_mutex;
std::shared_ptr<tbb::task_arena> wide;

std::shared_ptr<tbb::task_arena> wide_arena() {
    const std::lock_guard<std::mutex> lock(wide_mutex);
    return wide;
}

}  // namespace

void parallel_blocks(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) {
    if (count == 0) return;
    grain = std::max<std::size_t>(grain, 1);
    const std::size_t blocks = (count + grain - 1) / grain;
    const auto run = [&] {
        tbb::parallel_for(std::size_t{0}, blocks,
                          [&](std::size_t block) { body(block * grain, std::min(count, (block + 1) * grain)); });
    };
    if (const auto arena = wide_arena())
        arena->execute(run);
    else
        run();
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
    explicit Impl(std::size_t threads) : control(tbb::global_control::max_allowed_parallelism, threads) {
        const int count = thread_count();  // a limit around this one may be lower
        if (count <= tbb::info::default_concurrency()) return;
        const std::lock_guard<std::mutex> lock(wide_mutex);
        around = std::exchange(wide, std::make_shared<tbb::task_arena>(count));
        is_wide = true;
    }
    ~Impl() {
        if (!is_wide) return;
        const std::lock_guard<std::mutex> lock(wide_mutex);
        wide = std::move(around);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    tbb::global_control control;
    std::shared_ptr<tbb::task_arena> around;
    bool is_wide = false;
};

ThreadLimit::ThreadLimit(int threads) {
    if (threads > 0) impl_ = std::make_unique<Impl>(static_cast<std::size_t>(threads));
}

ThreadLimit::~ThreadLimit() = default;

int thread_count() {
    return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

std::string tbb_version() { return std::to_string(TBB_VERSION_MAJOR) + "." + std::to_string(TBB_VERSION_MINOR); }

}  // namespace surflux
