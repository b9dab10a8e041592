#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"
#include "surflux/radiosity/exchange.h"
#include "surflux/radiosity/pair_exchange.h"

namespace surflux {

// Fills an exchange, whose storage is all 0 so far, from of_pair(i, j, rays): the PairExchange::Pair of i < j with what
// blocks it; adds to `rays` what it took. It is called on many threads.
template <class OfPair>
void fill_all_pairs(Exchange& out, const Scene& scene, const PairExchange& pairs, const OfPair& of_pair,
                    const Progress& progress) {
    using Ends = std::pair<std::uint32_t, std::uint32_t>;
    constexpr std::size_t tile = 32;
    const std::size_t n = scene.surfels.size();
    out.size = n;
    out.areas = scene.surfels.areas;
    out.scale.assign(n, 1.0);
    out.sure.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) out.sure[i] = pairs.is_patch(i);

    // Rays of a tile then start and end close together, which Embree rewards.
    const std::vector<std::uint32_t> order = morton_order(scene.surfels.positions);
    // Pairs of tiles, upper triangle, numbered row by row.
    const std::size_t tiles = (n + tile - 1) / tile;
    std::vector<Ends> work;
    work.reserve(tiles * (tiles + 1) / 2);
    for (std::uint32_t r = 0; r < tiles; ++r)
        for (std::uint32_t c = r; c < tiles; ++c) work.emplace_back(r, c);
    std::vector<std::vector<Ends>> near(work.size());
    std::atomic<std::size_t> links{0}, rays{0};
    const auto fill = [&](std::size_t k) {
        const std::size_t row = tile * work[k].first, column = tile * work[k].second;
        std::size_t tile_links = 0, tile_rays = 0;
        for (std::size_t a = row; a < std::min(n, row + tile); ++a)
            for (std::size_t b = std::max(a + 1, column); b < std::min(n, column + tile); ++b) {
                // Lower index first: what a pair gets does not depend on the order of the curve.
                const std::uint32_t i = std::min(order[a], order[b]), j = std::max(order[a], order[b]);
                const PairExchange::Pair pair = of_pair(i, j, tile_rays);
                if (pair.exchange <= 0.0) continue;
                if (pair.range == PairExchange::Range::near && !(out.sure[i] && out.sure[j]))
                    near[k].emplace_back(i, j);
                ++tile_links;
                out.set(i, j, pair.exchange);
            }
        links += tile_links;
        rays += tile_rays;
    };
    parallel_blocks(
        work.size(), 1,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) fill(k);
        },
        progress);
    for (const std::vector<Ends>& found : near) out.near.insert(out.near.end(), found.begin(), found.end());
    std::sort(out.near.begin(), out.near.end());
    const std::vector<double> own = self_exchanges(scene, pairs);
    for (std::size_t i = 0; i < n; ++i) out.set(i, i, own[i]);
    out.links = links;
    out.rays = rays;
}

}  // namespace surflux
