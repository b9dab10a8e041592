#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "surflux/core/progress.h"

namespace surflux {

// Calls body(begin, end) over blocks of at most `grain` indices that cover [0, count), on all threads.
// The blocks do not depend on the number of threads: what a block computes, and so every result, is the same for any.
void parallel_blocks(std::size_t count, std::size_t grain,
                     const std::function<void(std::size_t begin, std::size_t end)>& body);

// The same with reports in between, often enough that a cancel takes effect within a fraction of a second
// when one index costs up to a few milliseconds.
void parallel_blocks(std::size_t count, std::size_t grain,
                     const std::function<void(std::size_t begin, std::size_t end)>& body, const Progress& progress);

template <class Body>
void parallel_for(std::size_t count, std::size_t grain, const Body& body, const Progress& progress = {}) {
    const auto of_block = [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(i);
    };
    parallel_blocks(count, grain, of_block, progress);
}

// The sum of what body(i, sum) adds up for all i: of each block by itself, then of the blocks in their order, so that
// it too is the same for any number of threads. A Sum starts as Sum{} and has +=.
template <class Sum, class Body>
Sum parallel_sum(std::size_t count, std::size_t grain, const Body& body) {
    grain = std::max<std::size_t>(grain, 1);
    std::vector<Sum> parts((count + grain - 1) / grain, Sum{});
    parallel_blocks(count, grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(i, parts[begin / grain]);
    });
    Sum all{};
    for (const Sum& part : parts) all += part;
    return all;
}

// How many of the first `count` of two sorted runs, merged, are of the first run.
template <class Item, class Less>
std::size_t rank_in_first(Item first, std::size_t n, Item second, std::size_t m, std::size_t count, const Less& less) {
    std::size_t low = count > m ? count - m : 0, high = std::min(count, n);
    while (low < high) {
        const std::size_t middle = low + (high - low) / 2;
        if (less(first[static_cast<std::ptrdiff_t>(middle)], second[static_cast<std::ptrdiff_t>(count - middle - 1)]))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

// Sorts by an order in which no two are equal: blocks by themselves, then merged two by two, pieces of a pair at once
// (merge path, Odeh and others 2012). It takes as much memory again.
template <class T, class Less>
void parallel_sort(std::vector<T>& values, const Less& less, const Progress& progress = {}) {
    constexpr std::size_t blocks = 64, pieces = 64;
    const std::size_t n = values.size();
    const auto at = [&](std::size_t block) { return n * block / blocks; };
    const auto in = [](std::vector<T>& of, std::size_t i) { return of.begin() + static_cast<std::ptrdiff_t>(i); };
    parallel_for(
        blocks, 1, [&](std::size_t block) { std::sort(in(values, at(block)), in(values, at(block + 1)), less); },
        progress);
    std::vector<T> merged(n);
    for (std::size_t width = 1; width < blocks; width *= 2) {
        const auto merge = [&](std::size_t piece) {
            // Its part of what comes of the pair that it is in.
            const std::size_t each = pieces / (blocks / (2 * width)), pair = 2 * width * (piece / each);
            const std::size_t first = at(pair), second = at(pair + width), end = at(pair + 2 * width);
            const std::size_t from = (end - first) * (piece % each) / each,
                              to = (end - first) * (piece % each + 1) / each;
            const auto rank = [&](std::size_t count) {
                return rank_in_first(in(values, first), second - first, in(values, second), end - second, count, less);
            };
            const std::size_t a = rank(from), b = rank(to);
            std::merge(in(values, first + a), in(values, first + b), in(values, second + from - a),
                       in(values, second + to - b), in(merged, first + from), less);
        };
        parallel_for(pieces, 1, merge, progress);
        values.swap(merged);
    }
}

// Scratch memory of a pass. Each block of its loops borrows one T, that nobody else has at the time: made where all
// others are lent, so that there are as many as blocks at once. All end with the pass.
template <class T>
class Scratch {
public:
    class Lent {
    public:
        explicit Lent(Scratch& of) : of_(of), mine_(of.take()) {}
        ~Lent() { of_.give_back(std::move(mine_)); }
        Lent(const Lent&) = delete;
        Lent& operator=(const Lent&) = delete;
        T& operator*() const { return *mine_; }

    private:
        Scratch& of_;
        std::unique_ptr<T> mine_;
    };

private:
    std::unique_ptr<T> take() {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (free_.empty()) {
            free_.reserve(++made_);  // so that giving back never throws
            return std::make_unique<T>();
        }
        std::unique_ptr<T> one = std::move(free_.back());
        free_.pop_back();
        return one;
    }
    void give_back(std::unique_ptr<T> one) {
        const std::lock_guard<std::mutex> lock(mutex_);
        free_.push_back(std::move(one));
    }

    std::mutex mutex_;
    std::vector<std::unique_ptr<T>> free_;
    std::size_t made_ = 0;
};

// out[k] = the sum of what add(i, sums) adds to sums[k] for all i: by a few blocks of i, each with sums of its own,
// which do not depend on the number of threads either. A Sum starts as Sum{} and has +=.
template <class Sum, class Add>
void parallel_scatter(std::size_t count, std::vector<Sum>& out, const Add& add, const Progress& progress = {}) {
    constexpr std::size_t blocks = 4, between_reports = 1 << 18;
    std::vector<std::vector<Sum>> sums(blocks);
    parallel_for(blocks, 1, [&](std::size_t block) { sums[block].assign(out.size(), Sum{}); });
    for (std::size_t done = 0; done * blocks < count; done += between_reports) {
        parallel_for(blocks, 1, [&](std::size_t block) {
            const std::size_t begin = block * count / blocks + done, end = (block + 1) * count / blocks;
            for (std::size_t i = begin; i < std::min(begin + between_reports, end); ++i) add(i, sums[block]);
        });
        report(progress, std::min(count, done * blocks), count);
    }
    parallel_for(out.size(), 4096, [&](std::size_t k) {
        out[k] = Sum{};
        for (const std::vector<Sum>& sum : sums) out[k] += sum[k];
    });
}

// While it lives, loops that this thread begins use at most this many threads (0: no other limit than before). Other
// threads of the process have limits of their own. It ends on the thread that began it.
class ThreadLimit {
public:
    explicit ThreadLimit(int threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit&) = delete;
    ThreadLimit& operator=(const ThreadLimit&) = delete;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

// How many threads a loop uses that this thread begins now.
int thread_count();

// `work` for a thread of its own: what that one begins keeps to the limit of this one.
std::function<void()> with_this_limit(std::function<void()> work);

// Calls work(), which begins loops of a library that uses TBB too: they keep to this thread's limit.
void within_limit(const std::function<void()>& work);

std::string tbb_version();

}  // namespace surflux
