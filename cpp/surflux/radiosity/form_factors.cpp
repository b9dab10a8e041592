#include "surflux/radiosity/form_factors.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "surflux/core/parallel.h"
#include "surflux/radiosity/all_pairs.h"
#include "surflux/radiosity/closure.h"
#include "surflux/radiosity/exchange.h"
#include "surflux/radiosity/shafts.h"
#include "surflux/radiosity/visible_share.h"

namespace surflux {

namespace {

constexpr double closure_tolerance = 1e-11;

// What rows of integrals may be off by, all together.
constexpr double row_precision = 1e-8;

Hemispheres nothing_lost(std::size_t surfels) {
    Hemispheres out;
    out.escape.assign(surfels, 0.0);
    out.absorbed.assign(surfels, 0.0);
    out.taken.assign(surfels, 0);
    return out;
}

// What rows lose. Those of patches that no ray had a say in lose what they lack; if they and rows that make 1 already
// are all, no ray is needed. Where none of a row's rays happens to escape, it would be taken for a closed one.
Hemispheres losses(const CompiledScene& compiled, const Exchange& exchange,
                   const std::vector<std::atomic<bool>>& estimated, const FormFactorOptions& options,
                   const Progress& progress) {
    const std::size_t n = exchange.size;
    std::vector<double> lacking = exchange.row_sums();
    bool known = true;
    for (std::size_t i = 0; i < n; ++i) {
        lacking[i] = 1.0 - lacking[i] / exchange.areas[i];
        known &= exchange.sure[i] && (!estimated[i] || std::abs(lacking[i]) <= row_precision);
    }
    Hemispheres out =
        known ? nothing_lost(n)
              : measure_hemispheres(compiled.scene(), compiled.tracer(), options.rays, options.seed, progress);
    for (std::size_t i = 0; i < n; ++i) {
        if (estimated[i]) continue;
        out.escape[i] = lacking[i] > row_precision ? lacking[i] : 0.0;
        out.absorbed[i] = 0.0;
        out.taken[i] = std::numeric_limits<std::uint32_t>::max();
    }
    return out;
}

}  // namespace

FormFactors form_factors(const CompiledScene& compiled, const FormFactorOptions& options, double* out,
                         const StageProgress& progress) {
    const Scene& scene = compiled.scene();
    const Surfels& s = scene.surfels;
    const std::size_t n = s.size();
    require_areas(scene);
    const Tracer& tracer = compiled.tracer(progress ? progress("trace") : Progress{});
    const PairExchange pairs(scene, options.epsilon, options.visibility);
    const Shafts shafts(scene);
    const VisibleShare share(tracer, pairs, shafts, options.error, options.seed, options.tuning);
    std::fill(out, out + n * n, 0.0);

    Exchange exchange;
    exchange.precise = out;
    std::atomic<std::size_t> imprecise{0};
    std::vector<std::atomic<bool>> estimated(n);  // rows in which rays, or the shape of a disk, have a say
    const auto of_pair = [&](std::uint32_t i, std::uint32_t j, std::size_t& rays) {
        PairExchange::Pair pair = pairs.precise(i, j);
        if (options.visibility && pair.exchange > 0.0) {
            const auto found = share(i, j, pair.range, pair.exchange / std::min(s.areas[i], s.areas[j]));
            pair.exchange *= found.value;
            rays += found.rays;
            imprecise += !found.precise;
            if (found.rays > 0 || !pairs.is_patch(i) || !pairs.is_patch(j)) estimated[i] = estimated[j] = true;
        }
        return pair;
    };
    fill_all_pairs(exchange, scene, pairs, of_pair, progress("exchange"));
    FormFactors result;
    result.rays = exchange.rays;
    result.imprecise = imprecise;
    if (options.visibility) {
        for (std::size_t i = 0; i < n; ++i)
            if (!exchange.sure[i] || exchange.at(i, i) > 0.0) estimated[i] = true;
        Hemispheres hemispheres = losses(compiled, exchange, estimated, options, progress("hemispheres"));
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
