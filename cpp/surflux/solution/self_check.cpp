#include "surflux/solution/self_check.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "surflux/core/random.h"
#include "surflux/solution/residual_rays.h"
#include "surflux/solution/stopwatch.h"

namespace surflux {

namespace {

constexpr std::uint64_t pick_stream = 0x5e1fc8ec;

// Irradiance of the scene's surfels: means over those inserted below each, by area.
std::vector<Rgb> means_of_scene(const Surfels& s, const Solution& solution, const Progress& progress) {
    std::vector<Rgb> out(s.size());
    std::vector<double> areas(s.size(), 0.0);
    for (std::size_t k = 0; k < solution.parents.size(); ++k) {
        report_some(progress, k, solution.parents.size(), 1 << 20);
        areas[solution.parents[k]] += solution.surfels.areas[k];
        out[solution.parents[k]] += solution.surfels.areas[k] * solution.irradiance[k];
    }
    report(progress, s.size(), s.size());
    for (std::size_t i = 0; i < s.size(); ++i)
        if (areas[i] > 0.0) out[i] *= 1.0 / areas[i];
    return out;
}

// Surfels that are checked, evenly along the list; those of much weight may come more than once.
struct Drawn {
    std::vector<std::uint32_t> surfels;
    std::vector<double> weights;  // of each, for means by area: 1 in the mean

    // In proportion to their area. Where those tell too little of the mean square of H, as under a spot on a wide
    // floor, of which few are lit, half of them go by what each has of that (defensive importance sampling, Hesterberg
    // 1995).
    Drawn(const Solution& solution, const SelfCheckOptions& options) {
        const Surfels& s = solution.surfels;
        const auto squared = [&](std::size_t i) { return dot(solution.irradiance[i], solution.irradiance[i]); };
        double sum = 0.0, area = 0.0, found = 0.0;
        for (std::size_t i = 0; i < s.size(); ++i) sum += s.areas[i] * squared(i), area += s.areas[i];
        draw(s, options, [](std::size_t) { return 1.0; });
        for (const std::uint32_t i : surfels) found += squared(i);
        const double most_off = options.tuning.most_off;
        const double mean = sum / area, by_those = found / static_cast<double>(surfels.size());
        if (!std::isfinite(mean) || (mean <= most_off * by_those && by_those <= most_off * mean)) return;
        draw(s, options, [&](std::size_t i) { return 0.5 + 0.5 * squared(i) / mean; });
    }

private:
    template <class Density>
    void draw(const Surfels& s, const SelfCheckOptions& options, const Density& density) {
        surfels.clear(), weights.clear();
        double total = 0.0, up_to = 0.0;
        for (std::uint32_t i = 0; i < s.size(); ++i) total += density(i) * s.areas[i];
        Random random(options.seed + pick_stream, 0);
        const double step = total / static_cast<double>(options.surfels);
        double next = step * random.uniform();
        for (std::uint32_t i = 0; i < s.size(); ++i)
            for (up_to += density(i) * s.areas[i]; next < up_to && surfels.size() < options.surfels; next += step)
                surfels.push_back(i), weights.push_back(1.0 / density(i));
    }
};

}  // namespace

SelfCheck gathering_error(const Scene& scene, const Tracer& tracer, const Solution& solution,
                          const SelfCheckOptions& options, const Progress& progress, const Team& team) {
    const Surfels& leaves = solution.surfels;
    const Progress starting = standing_at(0, 1, progress);
    report(starting, 0, 1);
    const Drawn checked(solution, options);
    const std::vector<std::uint32_t>& drawn = checked.surfels;
    if (drawn.empty()) return {};
    const std::vector<Rgb> of_scene = means_of_scene(scene.surfels, solution, starting);
    const SelfCheckTuning& tuning = options.tuning;
    const Regions regions(scene.surfels, of_scene,
                          std::max<std::size_t>(1, drawn.size() / whole_number(tuning.checks_per_region)), starting,
                          tuning);
    const SurfelPoints points(leaves);
    report(starting, 0, 1);
    const LightSampler lights(scene);
    const CloseLamps lamps(scene.lights);
    report(starting, 0, 1);
    // Of both halves: of each surfel first one, then the other.
    std::vector<ResidualRays::Sequences> sequences;
    for (std::size_t k = 0; k < 2 * drawn.size(); ++k) sequences.emplace_back(options.seed, k);
    std::vector<Gathered> sums(sequences.size(), Gathered(regions.count));
    std::vector<Residual> residuals;
    const auto radiosity = [&](std::size_t i) {
        return leaves.emission[i] + leaves.reflectance[i] * solution.irradiance[i];
    };
    for (std::size_t k = 0; k < drawn.size(); ++k) {
        const std::uint32_t i = drawn[k];
        residuals.push_back({solution.irradiance[i],
                             solution.direct[i],
                             radiosity(i),
                             regions.of[solution.parents[i]],
                             {&sums[2 * k], &sums[2 * k + 1]},
                             leaves.reflectance[i],
                             checked.weights[k]});
    }
    Rgb balance;
    double area = 0.0;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        report_some(starting, i, leaves.size(), 1 << 20);
        balance += leaves.areas[i] * (solution.direct[i] + radiosity(i) - solution.irradiance[i]);
        area += leaves.areas[i];
    }
    balance *= 1.0 / area;
    const auto digest = [&] {
        Digest of;
        of.add(options.seed);
        of.add(solution.irradiance);
        return of.value();
    };
    // Rounds, of which each doubles the rays.
    constexpr std::size_t grain = 8;
    std::vector<std::uint64_t> rays_of((drawn.size() + grain - 1) / grain, 0);  // by block, of all rounds
    std::size_t each = 0, more = whole_number(tuning.check_rays), planned = drawn.size() * more;
    while (4 * planned <= options.most_rays) planned *= 2;
    for (;; more = each) {
        const Progress of_round = [&](std::size_t done, std::size_t) {
            return !progress || progress(std::min(planned, drawn.size() * each + done * more), planned);
        };
        shared_blocks(
            team, "self-check", digest, drawn.size(), grain,
            [&](std::size_t begin, std::size_t end) {
                ResidualRays rays(scene.surfels, tracer, lights, lamps, of_scene, regions, points, tuning);
                for (std::size_t k = 2 * begin; k < 2 * end; ++k) {
                    const std::uint32_t i = drawn[k / 2];
                    const Place place{leaves.positions[i], leaves.normals[i], solution.parents[i], i, true};
                    rays.gather(place, static_cast<int>(more), sequences[k], sums[k]);
                }
                rays_of[begin / grain] += rays.rays;
            },
            [&](std::size_t begin, std::size_t end, Packed& to) {
                to.add(rays_of[begin / grain]);
                to.add(sequences.data() + 2 * begin, 2 * (end - begin));  // which go on where these rays end
                for (std::size_t k = 2 * begin; k < 2 * end; ++k) sums[k].pack(to);
            },
            [&](std::size_t begin, std::size_t end, Unpacking& from) {
                from.take(&rays_of[begin / grain], 1);
                from.take(sequences.data() + 2 * begin, 2 * (end - begin));
                for (std::size_t k = 2 * begin; k < 2 * end; ++k) sums[k].unpack(from);
            },
            of_round);
        each += more;
        const std::size_t traced = std::accumulate(rays_of.begin(), rays_of.end(), std::size_t{0});
        const ErrorEstimate estimate = error_from(residuals, regions, static_cast<double>(each), balance);
        const bool is_known =
            !(estimate.uncertainty > tuning.known_error * estimate.error) || 2 * traced > options.most_rays;
        const bool is_known_locally = !(estimate.local_floor > tuning.known_local_error * estimate.local_p90) ||
                                      2 * traced > options.most_local_rays;
        if (is_known && is_known_locally) {
            report(progress, planned, planned);
            return {estimate, traced};
        }
    }
}

void SelfCheck::note_in(Figures& figures) const {
    figure(figures, "rays") += static_cast<double>(rays);
    figure(figures, "error") = estimate.error;
    figure(figures, "error_uncertainty") = estimate.uncertainty;
    figure(figures, "local_error") = estimate.local;
    figure(figures, "local_error_p90") = estimate.local_p90;
}

void check_solution(const Scene& scene, const Tracer& tracer, std::uint64_t seed, const Progress& progress,
                    Solution& solution, const Team& team, const SelfCheckTuning& tuning) {
    Stopwatch watch(solution.timings);
    SelfCheckOptions options;
    options.surfels = whole_number(tuning.checked_surfels);
    options.seed = seed;
    options.tuning = tuning;
    Figures& figures = solution.history.back();
    options.most_local_rays = static_cast<std::size_t>(tuning.most_check_share * figure(figures, "rays"));
    options.most_rays = std::max(whole_number(tuning.least_check_rays), options.most_local_rays);
    const SelfCheck check = gathering_error(scene, tracer, solution, options, progress, team);
    watch.lap("self-check");
    solution.error = check.estimate.error;
    check.note_in(figures);
    figure(figures, "seconds") = total_seconds(solution.timings);
}

}  // namespace surflux
