#include "surflux/radiosity/form_factors.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"
#include "surflux/radiosity/closure.h"
#include "surflux/radiosity/exchange.h"
#include "surflux/radiosity/shafts.h"
#include "surflux/radiosity/visible_share.h"

namespace surflux {

namespace {

constexpr std::size_t tile = 32;
constexpr double closure_tolerance = 1e-11;

// Rows that make 1 already lose nothing that is worth a ray.
bool are_closed(const Exchange& exchange) {
    std::vector<double> sums;
    exchange.apply(std::vector<double>(exchange.size, 1.0), sums, 1);
    for (std::size_t i = 0; i < exchange.size; ++i)
        if (!exchange.sure[i] || std::abs(sums[i] / exchange.areas[i] - 1.0) > 1e-8) return false;
    return true;
}

Hemispheres nothing_lost(std::size_t surfels) {
    Hemispheres out;
    out.escape.assign(surfels, 0.0);
    out.absorbed.assign(surfels, 0.0);
    out.sky.assign(surfels, Rgb{});
    out.taken.assign(surfels, 0);
    return out;
}

}  // namespace

FormFactors form_factors(const Scene& scene, const FormFactorOptions& options, double* out,
                         const StageProgress& progress) {
    const Surfels& s = scene.surfels;
    const std::size_t n = s.size();
    require_areas(s);
    const Tracer tracer(scene);
    const PairExchange pairs(scene, options.epsilon);
    const Shafts shafts(scene);
    const VisibleShare share(tracer, pairs, shafts, options.error, options.seed);
    // Rays of a tile then start and end close together, which Embree rewards.
    const std::vector<std::uint32_t> order = morton_order(s.positions);
    std::fill(out, out + n * n, 0.0);

    std::atomic<std::size_t> rays{0}, imprecise{0};
    std::vector<NearPairs> near;
    const auto fill = [&](std::size_t block, std::size_t row_tile, std::size_t col_tile) {
        std::size_t tile_rays = 0, tile_imprecise = 0;
        for (std::size_t a = row_tile * tile; a < std::min(n, (row_tile + 1) * tile); ++a)
            for (std::size_t b = std::max(a + 1, col_tile * tile); b < std::min(n, (col_tile + 1) * tile); ++b) {
                // Lower index first: what a pair gets does not depend on the order of the curve.
                const std::uint32_t i = std::min(order[a], order[b]), j = std::max(order[a], order[b]);
                const PairExchange::Pair pair = pairs.precise(i, j);
                double g = pair.exchange;
                if (g <= 0.0) continue;
                if (options.visibility) {
                    const auto found = share(i, j, pair.range, g / std::min(s.areas[i], s.areas[j]));
                    g *= found.value;
                    tile_rays += found.rays;
                    tile_imprecise += !found.precise;
                }
                near[block].add(pairs, i, j, pair.range);
                out[i * n + j] = out[j * n + i] = g;
            }
        rays += tile_rays;
        imprecise += tile_imprecise;
    };
    // Pairs of tiles, upper triangle, numbered row by row.
    const std::size_t tiles = (n + tile - 1) / tile;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> work;
    work.reserve(tiles * (tiles + 1) / 2);
    for (std::uint32_t r = 0; r < tiles; ++r)
        for (std::uint32_t c = r; c < tiles; ++c) work.emplace_back(r, c);
    near.resize(work.size());
    parallel_blocks(
        work.size(), 1,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) fill(k, work[k].first, work[k].second);
        },
        progress("exchange"));
    const std::vector<double> own = self_exchanges(scene, pairs);
    for (std::size_t i = 0; i < n; ++i) out[i * n + i] = own[i];

    Exchange exchange;
    exchange.size = n;
    exchange.precise = out;
    exchange.areas = s.areas;
    exchange.scale.assign(n, 1.0);
    for (std::uint32_t i = 0; i < n; ++i) exchange.sure.push_back(pairs.is_patch(i));
    NearPairs::take_all(near, exchange);
    FormFactors result;
    result.rays = rays;
    result.imprecise = imprecise;
    if (options.visibility) {
        Hemispheres hemispheres = are_closed(exchange) ? nothing_lost(n)
                                                       : measure_hemispheres(scene, tracer, options.rays, options.seed,
                                                                             progress("hemispheres"));
        close(exchange, hemispheres, progress("closure"), closure_tolerance);
        result.rest.resize(n);
        for (std::size_t i = 0; i < n; ++i) result.rest[i] = hemispheres.escape[i] + hemispheres.absorbed[i];
        result.rays += hemispheres.rays;
    }
    parallel_for(n, 8, [&](std::size_t i) {
        for (std::size_t j = 0; j < n; ++j) out[i * n + j] *= exchange.scale[i] * exchange.scale[j] / s.areas[i];
    });
    return result;
}

}  // namespace surflux
