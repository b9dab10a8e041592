#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <type_traits>
#include <vector>

#include "surflux/core/error.h"
#include "surflux/core/float_sum.h"
#include "surflux/core/parallel.h"

namespace surflux {

// Values of red, green and blue, and one that is 0: as many floats as one SIMD register has.
inline constexpr std::size_t colors = 4;

// Calls work(channels), where the usual numbers are constants that the compiler unrolls loops by.
template <class Work>
void with_fixed(std::size_t channels, const Work& work) {
    if (channels == colors) return work(std::integral_constant<std::size_t, colors>());
    if (channels == 3 * colors) return work(std::integral_constant<std::size_t, 3 * colors>());
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
    void end_row() {
        require_few(entries.size());
        begin.push_back(static_cast<std::uint32_t>(entries.size()));
    }
    // Rows of another one behind its own.
    void append(const SparseRows& other) {
        require_few(entries.size() + other.entries.size());
        const auto offset = static_cast<std::uint32_t>(entries.size());
        entries.insert(entries.end(), other.entries.begin(), other.entries.end());
        for (std::size_t row = 1; row < other.begin.size(); ++row) begin.push_back(offset + other.begin[row]);
    }

    // Rows of so many entries each, which are to be filled in: all memory at once.
    void resize_rows(const std::vector<std::uint32_t>& counts) {
        require_few(std::accumulate(counts.begin(), counts.end(), std::size_t{0}));
        begin.assign(counts.size() + 1, 0);
        for (std::size_t row = 0; row < counts.size(); ++row) begin[row + 1] = begin[row] + counts[row];
        entries.resize(begin.back());
    }

    template <class Visit>
    void for_row(std::size_t row, const Visit& visit) const {
        for (std::uint32_t k = begin[row]; k < begin[row + 1]; ++k) visit(entries[k].column, entries[k].weight);
    }

    // visit(row, sum): sum[c] = sum over columns of weight * values[column * channels + c].
    template <class Visit>
    void multiply(const std::vector<float>& values, std::size_t channels, const Visit& visit) const {
        with_fixed(channels, [&](const auto count) { multiply_by(values, count, visit); });
    }

private:
    static void require_few(std::size_t count) {
        require(count <= std::numeric_limits<std::uint32_t>::max(), "a sparse matrix of more than 2^32 entries");
    }

    template <class Channels, class Visit>
    void multiply_by(const std::vector<float>& values, const Channels channels, const Visit& visit) const {
        constexpr std::size_t ahead = 16;  // entries
        parallel_for(rows(), 512, [&](std::size_t row) {
            auto sum = float_sum(channels);
            for (std::uint32_t k = begin[row]; k < begin[row + 1]; ++k) {
                if (k + ahead < entries.size())
                    __builtin_prefetch(values.data() + entries[k + ahead].column * channels);
                sum.add(entries[k].weight, values.data() + entries[k].column * channels);
            }
            visit(row, sum.data());
        });
    }
};

}  // namespace surflux
