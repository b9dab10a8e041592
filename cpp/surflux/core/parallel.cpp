#include "surflux/core/parallel.h"

#include <algorithm>
#include <chrono>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/version.h>

namespace surflux {

namespace tbb = oneapi::tbb;

void parallel_blocks(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) {
    if (count == 0) return;
    grain = std::max<std::size_t>(grain, 1);
    const std::size_t blocks = (count + grain - 1) / grain;
    tbb::parallel_for(std::size_t{0}, blocks,
                      [&](std::size_t block) { body(block * grain, std::min(count, (block + 1) * grain)); });
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
    explicit Impl(std::size_t threads) : control(tbb::global_control::max_allowed_parallelism, threads) {}
    tbb::global_control control;
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
