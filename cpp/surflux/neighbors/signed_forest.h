#pragma once

#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace surflux {

// Which tree each item is in, and whether it is turned against the root (union-find with parity).
class SignedForest {
public:
    explicit SignedForest(std::size_t n) : parent_(n), size_(n, 1), turned_(n, 0) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }
    std::uint32_t root(std::uint32_t i, bool& turned) const {
        turned = false;
        for (; parent_[i] != i; i = parent_[i]) turned ^= turned_[i] != 0;
        return i;
    }
    std::uint32_t root(std::uint32_t i) const {
        while (parent_[i] != i) i = parent_[i];
        return i;
    }
    std::uint32_t size(std::uint32_t root) const { return size_[root]; }
    // `opposite`: a and b face opposite ways.
    void join(std::uint32_t item_a, std::uint32_t item_b, bool opposite) {
        bool turned_a, turned_b;
        std::uint32_t a = root(item_a, turned_a), b = root(item_b, turned_b);
        if (a == b) return;
        if (size_[a] < size_[b]) std::swap(a, b);  // no path gets longer than log2 n
        parent_[b] = a;
        turned_[b] = turned_a ^ turned_b ^ opposite;
        size_[a] += size_[b];
    }

private:
    std::vector<std::uint32_t> parent_, size_;
    std::vector<std::uint8_t> turned_;
};

}  // namespace surflux
