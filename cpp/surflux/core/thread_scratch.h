#pragma once

#include <cstddef>
#include <vector>

namespace surflux {

// For a vector that a thread keeps from call to call, so that most calls allocate nothing: empties it for this call,
// and gives its memory back at the end where that is more than most calls need. What one large disk finds among a
// million small ones would stay for the life of the process otherwise, once for every thread.
template <class T>
class ThreadScratch {
public:
    static constexpr std::size_t most_kept = std::size_t{1} << 16;  // bytes

    explicit ThreadScratch(std::vector<T>& kept) : kept_(kept) { kept_.clear(); }
    ~ThreadScratch() {
        if (kept_.capacity() > most_kept / sizeof(T)) std::vector<T>().swap(kept_);
    }
    ThreadScratch(const ThreadScratch&) = delete;
    ThreadScratch& operator=(const ThreadScratch&) = delete;

private:
    std::vector<T>& kept_;
};

}  // namespace surflux
