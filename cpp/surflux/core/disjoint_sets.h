#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace surflux {

// Union-find (Tarjan 1975), by path halving; the least member stands for a set, so that numbers do not depend on the
// order in which sets were joined.
class DisjointSets {
public:
    explicit DisjointSets(std::size_t count) : above_(count) { std::iota(above_.begin(), above_.end(), 0u); }

    std::uint32_t find(std::uint32_t k) {
        while (above_[k] != k) k = above_[k] = above_[above_[k]];
        return k;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = find(a), b = find(b);
        if (a < b) above_[b] = a;
        if (b < a) above_[a] = b;
    }
    // Sets numbered from 0 in the order of their least members, by the first `count` members.
    std::vector<std::uint32_t> numbered(std::size_t count) {
        std::vector<std::uint32_t> number(above_.size(), none), out(count);
        std::uint32_t next = 0;
        for (std::uint32_t k = 0; k < count; ++k) {
            std::uint32_t& of_set = number[find(k)];
            if (of_set == none) of_set = next++;
            out[k] = of_set;
        }
        return out;
    }

private:
    static constexpr std::uint32_t none = 0xffffffffu;
    std::vector<std::uint32_t> above_;
};

}  // namespace surflux
