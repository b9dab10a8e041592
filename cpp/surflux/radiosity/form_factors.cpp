#include "surflux/radiosity/form_factors.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/radiosity/all_pairs.h"
#include "surflux/radiosity/closure.h"
#include "surflux/radiosity/exchange.h"
#include "surflux/radiosity/shafts.h"
#include "surflux/radiosity/visible_share.h"

namespace surflux {

namespace {

constexpr double closure_tolerance = 1e-11;

// Rows that make 1 already lose nothing that is worth a ray.
bool are_closed(const Exchange& exchange) {
    const std::vector<double> sums = exchange.row_sums();
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

FormFactors form_factors(const CompiledScene& compiled, const FormFactorOptions& options, double* out,
                         const StageProgress& progress) {
    const Scene& scene = compiled.scene();
    const Surfels& s = scene.surfels;
    const std::size_t n = s.size();
    require_areas(s);
    const Tracer& tracer = compiled.tracer();
    const PairExchange pairs(scene, options.epsilon, options.visibility);
    const Shafts shafts(scene);
    const VisibleShare share(tracer, pairs, shafts, options.error, options.seed);
    std::fill(out, out + n * n, 0.0);

    Exchange exchange;
    exchange.precise = out;
    std::atomic<std::size_t> imprecise{0};
    const auto of_pair = [&](std::uint32_t i, std::uint32_t j, std::size_t& rays) {
        PairExchange::Pair pair = pairs.precise(i, j);
        if (options.visibility && pair.exchange > 0.0) {
            const auto found = share(i, j, pair.range, pair.exchange / std::min(s.areas[i], s.areas[j]));
            pair.exchange *= found.value;
            rays += found.rays;
            imprecise += !found.precise;
        }
        return pair;
    };
    fill_all_pairs(exchange, scene, pairs, of_pair, progress("exchange"));
    FormFactors result;
    result.rays = exchange.rays;
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
