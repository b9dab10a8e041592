#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/span.h"
#include "surflux/core/team.h"
#include "surflux/solution/interpolation.h"

namespace surflux {

// The matrix P that takes values at the sites of an Interpolation to many places: sparse rows, with weights as floats.
class InterpolationMatrix {
public:
    class Row {
    public:
        Row() = default;
        Row(std::uint32_t site, double weight) { add({site, weight}); }
        Row(Span<Interpolation::Weight> weights) {  // NOLINT: weights at a place are a row
            for (const Interpolation::Weight& w : weights) add(w);
        }
        void add(const Interpolation::Weight& weight) { weights_[size_++] = weight; }
        const Interpolation::Weight* begin() const { return weights_.data(); }
        const Interpolation::Weight* end() const { return weights_.data() + size_; }
        bool empty() const { return size_ == 0; }
        operator Span<Interpolation::Weight>() const { return {begin(), end()}; }  // NOLINT

    private:
        std::array<Interpolation::Weight, Interpolation::most_sites> weights_;
        std::size_t size_ = 0;
    };

    // Each place's row as `weights_at` has it, which is asked on many threads at once.
    using WeightsAt = std::function<void(std::size_t place, std::vector<Interpolation::Weight>& out)>;
    // `digest`: of what the weights go by, for a team that shares (core/team.h).
    void fill(std::size_t places, const WeightsAt& weights_at, const Progress& progress = {}, const Team& team = {},
              const std::function<std::uint64_t()>& digest = {});
    void clear();
    bool empty() const { return blocks_.empty(); }

    Row operator[](std::size_t place) const;

private:
    struct Entry {
        std::uint32_t site;
        float weight;
    };
    static constexpr std::size_t grain = 256;  // places of a block
    struct Block {
        std::vector<Entry> entries;
        std::array<std::uint16_t, grain + 1> begin;  // of the row of each place
    };
    std::vector<Block> blocks_;
};

}  // namespace surflux
