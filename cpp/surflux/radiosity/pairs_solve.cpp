#include "surflux/radiosity/pairs_solve.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/disjoint_sets.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/hemisphere.h"
#include "surflux/lights/light_sampler.h"
#include "surflux/radiosity/closure.h"
#include "surflux/solution/channels.h"
#include "surflux/solution/conjugate_gradients.h"
#include "surflux/solution/power_balance.h"
#include "surflux/solution/stopwatch.h"

namespace surflux {

namespace {

constexpr int max_applications = 1000;

// H of H = D + F (E + rho H). With M = A^-1/2 G A^-1/2 (G the closed exchange) the system
// (I - sqrt(rho) M sqrt(rho)) y = sqrt(A rho) H0, H = H0 + A^-1/2 M sqrt(rho) y, H0 = D + F E,
// is symmetric, positive definite as long as rho < 1, and takes rho = 0. `emitted` is F E of what `emitters` sample,
// and left empty where they sample nothing.
LinearReport solve_irradiance(const Exchange& exchange, const Surfels& s, const LightSampler& emitters,
                              const std::vector<Rgb>& direct, double tolerance, const std::vector<std::uint32_t>& parts,
                              std::vector<Rgb>& irradiance, std::vector<Rgb>& emitted, std::size_t& channel_count,
                              const Progress& progress) {
    const Channels channels(is_grey(s.reflectance) && is_grey(s.emission) && is_grey(direct));
    channel_count = channels.count;
    const std::vector<double> rho = channels.pack(s.reflectance);
    const auto area = [&](std::size_t k) { return exchange.areas[k / channels.count]; };

    std::vector<double> h0, work, product;
    exchange.apply(channels.pack(s.emission), h0, channels.count);
    for (std::size_t k = 0; k < h0.size(); ++k) h0[k] /= area(k);
    if (!emitters.empty()) {
        std::vector<Rgb> sampled(s.size());
        for (std::uint32_t i = 0; i < s.size(); ++i)
            if (emitters.samples(i)) sampled[i] = s.emission[i];
        exchange.apply(channels.pack(sampled), work, channels.count);
        for (std::size_t k = 0; k < work.size(); ++k) work[k] /= area(k);
        emitted = channels.unpack(work);
    }
    const std::vector<double> d = channels.pack(direct);
    std::vector<double> b(h0.size()), weight(h0.size());
    for (std::size_t k = 0; k < h0.size(); ++k) {
        h0[k] += d[k];
        b[k] = std::sqrt(area(k) * rho[k]) * h0[k];
        weight[k] = std::sqrt(rho[k] / area(k));
    }
    const auto gathered = [&](const std::vector<double>& y) {
        work.resize(y.size());
        for (std::size_t k = 0; k < y.size(); ++k) work[k] = weight[k] * y[k];
        exchange.apply(work, product, channels.count);
    };
    const LinearOperator apply = [&](const std::vector<double>& y, std::vector<double>& out) {
        gathered(y);
        out.resize(y.size());
        for (std::size_t k = 0; k < y.size(); ++k) out[k] = y[k] - weight[k] * product[k];
    };
    std::vector<double> y;
    const LinearReport report =
        conjugate_gradients(apply, b, LinearSystems(channels.count, parts), tolerance, max_applications, y, progress);
    gathered(y);
    for (std::size_t k = 0; k < h0.size(); ++k) h0[k] += product[k] / area(k);
    irradiance = channels.unpack(h0);
    return report;
}

// What rows lack adds up over all bounces, 1 / (1 - rho) of them.
double closure_tolerance(const Surfels& s) {
    double least = 1.0;
    for (const Rgb& rho : s.reflectance) least = std::min({least, 1.0 - rho.x, 1.0 - rho.y, 1.0 - rho.z});
    return std::clamp(1e-5 * least, 1e-13, 1e-7);
}

// The connected part of each surfel: of those that exchange light, by any number of bounces.
std::vector<std::uint32_t> connected_parts(const Exchange& exchange, const Progress& progress) {
    DisjointSets sets(exchange.size);
    for (std::uint32_t i = 0; i < exchange.size; ++i) {
        report_some(progress, i, exchange.size, 64);
        for (std::uint32_t j = i + 1; j < exchange.size; ++j)
            if (exchange.at(i, j) > 0.0) sets.join(i, j);
    }
    return sets.numbered(exchange.size);
}

}  // namespace

void solve_by_pairs(const Scene& scene, const Tracer& tracer, const LitPoints& lit, const PairsOptions& options,
                    const StageProgress& progress, Solution& out) {
    const Surfels& s = scene.surfels;
    const std::size_t n = s.size();
    const auto stage = [&](const char* name) { return progress ? progress(name) : Progress{}; };
    Stopwatch watch(out.timings);
    Hemispheres hemispheres = measure_hemispheres(scene, tracer, options.rays, options.seed, stage("hemispheres"));
    watch.lap("hemispheres");
    Exchange exchange = exchange_of_all_pairs(scene, &tracer, options.exchange, options.seed, stage("exchange"));
    watch.lap("exchange");
    const Closure closure =
        close(exchange, hemispheres, stage("closure"), closure_tolerance(s), options.exchange.tuning);
    watch.lap("closure");

    out.direct.resize(n);
    for (std::size_t i = 0; i < n; ++i)
        out.direct[i] = lit.from_lights(i) + (pi * hemispheres.escape[i]) * hemispheres.constant_sky;
    const std::vector<std::uint32_t> parts = connected_parts(exchange, stage("solve"));
    std::size_t channels = 0;
    const LightSampler emitters = LightSampler::of_surfels(scene);
    const LinearReport linear = solve_irradiance(exchange, s, emitters, out.direct, options.tolerance, parts,
                                                 out.irradiance, out.emitted, channels, stage("solve"));
    out.surfels = s;
    out.parents.resize(n);
    out.radiosity.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        out.parents[i] = static_cast<std::uint32_t>(i);
        out.radiosity[i] = s.emission[i] + s.reflectance[i] * out.irradiance[i];
    }
    watch.lap("solve");
    Figures figures{{"surfels", static_cast<double>(n)},
                    {"cut", static_cast<double>(n)},
                    {"inserted", 0.0},
                    {"links", static_cast<double>(exchange.links)},
                    {"rays", static_cast<double>(exchange.rays + hemispheres.rays)},
                    {"channels", static_cast<double>(channels)},
                    {"applications", static_cast<double>(linear.applications)},
                    {"residual", linear.residual},
                    {"largest_correction", closure.largest_correction},
                    {"closure_residual", closure.residual},
                    {"largest_shortfall", closure.largest_shortfall},
                    {"short_rows", static_cast<double>(closure.short_rows)},
                    {"closure_applications", static_cast<double>(closure.applications)}};
    PowerBalance power;
    for (std::size_t i = 0; i < n; ++i)
        power.add(parts[i], {s.areas[i],
                             s.reflectance[i],
                             s.emission[i],
                             out.direct[i],
                             out.irradiance[i],
                             {hemispheres.escape[i], hemispheres.absorbed[i]}});
    const Figures balance = power.figures();
    figures.insert(figures.end(), balance.begin(), balance.end());
    out.history.push_back(std::move(figures));
}

}  // namespace surflux
