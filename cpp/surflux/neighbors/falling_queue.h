#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace surflux {

// A bucket priority queue with decrease-key: items with keys that only ever fall, the largest key first; `wins(i, j)`
// says which of equal ones. Buckets hold items of about one key, and only the highest is ordered, as a heap that stays
// in cache: in one heap of all, each item that has fallen would sink through all levels.
template <class Wins>
class FallingQueue {
public:
    // Items 0 to keys.size() - 1. The caller keeps their keys, and lowers them as it likes.
    FallingQueue(const std::vector<double>& keys, const Wins& wins) : keys_(keys), wins_(wins) {
        for (std::uint32_t i = 0; i < keys.size(); ++i) put(i);
        top_ = buckets_.size();
    }

    // Takes out the item with the largest key. There has to be one.
    std::uint32_t take() {
        for (;;) {
            while (heap_.empty()) open_next();
            const Entry first = heap_.front();
            std::pop_heap(heap_.begin(), heap_.end(), below());
            heap_.pop_back();
            if (keys_[first.item] == first.key) return first.item;
            if (bucket_of(keys_[first.item]) < top_) {
                put(first.item);
            } else {
                heap_.push_back({keys_[first.item], first.item});
                std::push_heap(heap_.begin(), heap_.end(), below());
            }
        }
    }

private:
    struct Entry {
        double key;  // as it was: an item's present key is no larger
        std::uint32_t item;
    };
    static constexpr double least = 0x1p-64;  // keys up to this one are all in bucket 0
    static constexpr int digits = 5;          // 32 buckets to an octave

    // Positive doubles are in the order of their bits.
    static std::size_t bucket_of(double key) {
        if (!(key > least)) return 0;
        std::uint64_t bits, lowest;
        std::memcpy(&bits, &key, sizeof bits);
        std::memcpy(&lowest, &least, sizeof lowest);
        return 1 + static_cast<std::size_t>((bits - lowest) >> (52 - digits));
    }

    auto below() const {
        return
            [this](const Entry& a, const Entry& b) { return a.key != b.key ? a.key < b.key : wins_(b.item, a.item); };
    }

    void put(std::uint32_t item) {
        const std::size_t bucket = bucket_of(keys_[item]);
        if (bucket >= buckets_.size()) buckets_.resize(bucket + 1);
        buckets_[bucket].push_back(item);
    }

    void open_next() {
        const std::vector<std::uint32_t> items = std::move(buckets_[--top_]);
        for (const std::uint32_t item : items)
            if (bucket_of(keys_[item]) < top_)
                put(item);
            else
                heap_.push_back({keys_[item], item});
        std::make_heap(heap_.begin(), heap_.end(), below());
    }

    const std::vector<double>& keys_;
    Wins wins_;
    std::vector<std::vector<std::uint32_t>> buckets_;
    std::size_t top_;  // the bucket that the heap holds
    std::vector<Entry> heap_;
};

}  // namespace surflux
