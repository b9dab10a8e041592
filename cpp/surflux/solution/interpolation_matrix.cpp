#include "surflux/solution/interpolation_matrix.h"

namespace surflux {

void InterpolationMatrix::fill(std::size_t places, const WeightsAt& weights_at, const Progress& progress,
                               const Team& team, const std::function<std::uint64_t()>& digest) {
    clear();
    blocks_.resize((places + grain - 1) / grain);
    shared_blocks(
        team, "interpolation", digest, places, grain,
        [&](std::size_t from, std::size_t to) {
            std::vector<Interpolation::Weight> near;
            std::vector<Entry> entries;
            Block& block = blocks_[from / grain];
            block.begin[0] = 0;
            for (std::size_t place = from; place < to; ++place) {
                near.clear();
                weights_at(place, near);
                for (const Interpolation::Weight& w : near) entries.push_back({w.site, static_cast<float>(w.weight)});
                block.begin[place - from + 1] = static_cast<std::uint16_t>(entries.size());
            }
            block.entries.assign(entries.begin(), entries.end());
        },
        [&](std::size_t from, std::size_t to, Packed& bytes) {
            const Block& block = blocks_[from / grain];
            bytes.add(block.begin.data(), to - from + 1);
            bytes.add(block.entries.data(), block.entries.size());
        },
        [&](std::size_t from, std::size_t to, Unpacking& bytes) {
            Block& block = blocks_[from / grain];
            bytes.take(block.begin.data(), to - from + 1);
            block.entries.resize(block.begin[to - from]);
            bytes.take(block.entries.data(), block.entries.size());
        },
        progress);
}

void InterpolationMatrix::clear() { std::vector<Block>().swap(blocks_); }

InterpolationMatrix::Row InterpolationMatrix::operator[](std::size_t place) const {
    const Block& block = blocks_[place / grain];
    const std::size_t k = place % grain;
    Row out;
    for (std::size_t e = block.begin[k]; e < block.begin[k + 1]; ++e)
        out.add({block.entries[e].site, static_cast<double>(block.entries[e].weight)});
    return out;
}

}  // namespace surflux
