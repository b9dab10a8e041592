#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "surflux/core/parallel.h"

namespace surflux {

// Calls work(channels), where the usual numbers are constants that the compiler unrolls loops by.
template <class Work>
void with_fixed(std::size_t channels, const Work& work) {
    if (channels == 3) return work(std::integral_constant<std::size_t, 3>());
    if (channels == 12) return work(std::integral_constant<std::size_t, 12>());
    work(channels);
}

// A sparse matrix by rows (CSR) in floats, that is multiplied by vectors of any number of channels.
struct SparseRows {
    struct Entry {
        std::uint32_t column;
        float weight;
    };
    std::vector<std::uint32_t> begin{0};  // of each row, and the end
    std::vector<Entry> entries;

    std::size_t rows() const { return begin.size() - 1; }
    void end_row() { begin.push_back(static_cast<std::uint32_t>(entries.size())); }

    template <class Visit>
    void for_row(std::size_t row, const Visit& visit) const {
        for (std::uint32_t k = begin[row]; k < begin[row + 1]; ++k) visit(entries[k].column, entries[k].weight);
    }

    // visit(row, sums): sums[c] = sum over columns of weight * values[column * channels + c].
    template <class Visit>
    void multiply(const std::vector<float>& values, std::size_t channels, const Visit& visit) const {
        with_fixed(channels, [&](const auto count) { multiply_by(values, count, visit); });
    }

private:
    template <class Channels, class Visit>
    void multiply_by(const std::vector<float>& values, const Channels channels, const Visit& visit) const {
        parallel_blocks(rows(), 512, [&](std::size_t from, std::size_t to) {
            std::vector<float> sums(channels);
            for (std::size_t row = from; row < to; ++row) {
                std::fill(sums.begin(), sums.end(), 0.0f);
                float* sum = sums.data();
                for (std::uint32_t k = begin[row]; k < begin[row + 1]; ++k) {
                    const float* of = values.data() + entries[k].column * channels;
                    const float weight = entries[k].weight;
                    for (std::size_t c = 0; c < channels; ++c) sum[c] += weight * of[c];
                }
                visit(row, sum);
            }
        });
    }
};

}  // namespace surflux
