#include "surflux/solution/self_check.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <vector>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/solution/residual_rays.h"
#include "surflux/solution/stopwatch.h"

namespace surflux {

namespace {

constexpr int least_rays_each = 32;  // of each half, of each surfel
constexpr std::size_t checks_per_region = 32;
constexpr int most_bounces = 10000;
// Relative standard error of the square of the error at which no more paths are traced, and how many rays are, whatever
// it is: that many at least, and of a solution's own rays that share.
constexpr double enough = 0.125;
constexpr std::size_t least_rays = 1 << 20;
constexpr double most_share = 0.25;
constexpr std::uint64_t pick_stream = 0x5e1fc8ec;

// Irradiance of the scene's surfels: means over those inserted below each, by area.
std::vector<Rgb> means_of_scene(const Surfels& s, const Solution& solution) {
    std::vector<Rgb> out(s.size());
    std::vector<double> areas(s.size(), 0.0);
    for (std::size_t k = 0; k < solution.parents.size(); ++k) {
        areas[solution.parents[k]] += solution.surfels.areas[k];
        out[solution.parents[k]] += solution.surfels.areas[k] * solution.irradiance[k];
    }
    for (std::size_t i = 0; i < s.size(); ++i) out[i] *= 1.0 / areas[i];
    return out;
}

// Surfels in proportion to their area, evenly along the list; large ones may come more than once.
std::vector<std::uint32_t> drawn_by_area(const Surfels& s, std::size_t count, std::uint64_t seed) {
    std::vector<std::uint32_t> out;
    double total = 0.0, up_to = 0.0;
    for (double area : s.areas) total += area;
    Random random(seed + pick_stream, 0);
    const double step = total / static_cast<double>(count);
    double next = step * random.uniform();
    for (std::uint32_t i = 0; i < s.size(); ++i)
        for (up_to += s.areas[i]; next < up_to && out.size() < count; next += step) out.push_back(i);
    return out;
}

struct Checked {
    Rgb irradiance;  // by the solution
    std::uint32_t region;
    const Gathered* halves[2];
};

// Errors of the solution at each check by one half of the rays: its residual there, and what errors elsewhere bring,
// which are those of the regions' means: they solve e = r + T e between regions (defect correction on a coarse grid).
class HalfErrors {
public:
    HalfErrors(const std::vector<Checked>& checks, std::size_t regions, int half, double rays)
        : checks_(checks), regions_(regions), half_(half), rays_(rays) {
        std::vector<double> count(regions, 0.0);
        std::vector<Rgb> residual(regions), from(regions * regions);
        for (const Checked& c : checks_) {
            count[c.region] += 1.0;
            residual[c.region] += residual_of(c);
            for (const Gathered* half_of : c.halves)
                for (std::size_t g = 0; g < regions; ++g) from[c.region * regions + g] += half_of->from[g] / (2.0 * rays);
        }
        for (std::size_t k = 0; k < regions; ++k) {
            if (count[k] == 0.0) continue;
            residual[k] *= 1.0 / count[k];
            for (std::size_t g = 0; g < regions; ++g) from[k * regions + g] *= 1.0 / count[k];
        }
        mean_ = residual;
        std::vector<Rgb> next(regions);
        for (int step = 0; step < most_bounces; ++step) {
            double change = 0.0, size = 0.0;
            for (std::size_t k = 0; k < regions; ++k) {
                next[k] = residual[k];
                for (std::size_t g = 0; g < regions; ++g) next[k] += from[k * regions + g] * mean_[g];
                const Rgb moved = next[k] - mean_[k];
                change += dot(moved, moved), size += dot(next[k], next[k]);
            }
            mean_.swap(next);
            if (change <= 1e-12 * size) break;
        }
    }
    Rgb residual_of(const Checked& c) const { return c.halves[half_]->irradiance / rays_ - c.irradiance; }
    // What errors elsewhere bring.
    Rgb from_others(const Checked& c) const {
        Rgb sum;
        for (const Gathered* half_of : c.halves)
            for (std::size_t g = 0; g < regions_; ++g) sum += half_of->from[g] / (2.0 * rays_) * mean_[g];
        return sum;
    }

private:
    const std::vector<Checked>& checks_;
    std::size_t regions_;
    int half_;
    double rays_;
    std::vector<Rgb> mean_;
};

SelfCheck error_of(const std::vector<Checked>& checks, std::size_t regions, int rays) {
    const HalfErrors one(checks, regions, 0, rays), two(checks, regions, 1, rays);
    double off = 0.0, all = 0.0, spread = 0.0, common = 0.0;
    for (const Checked& c : checks) {
        const Rgb others = one.from_others(c), others_too = two.from_others(c);
        const Rgb e = one.residual_of(c) + others, e_too = two.residual_of(c) + others_too;
        const double product = dot(e, e_too);
        off += product, spread += product * product;
        all += dot(c.irradiance + e, c.irradiance + e_too);
        common += dot(others - others_too, others - others_too) / 2.0;
    }
    if (!(all > 0.0)) return {};
    const double deviation = std::sqrt(spread + common * common);
    SelfCheck out;
    // Below the standard error of the sum nothing is known: that is the least it claims.
    out.error = std::sqrt(std::max(off, deviation) / all);
    out.uncertainty = deviation / (2.0 * out.error * all);
    return out;
}

}  // namespace

SelfCheck gathering_error(const Scene& scene, const Tracer& tracer, const Solution& solution,
                          const SelfCheckOptions& options, const Progress& progress) {
    const Surfels& leaves = solution.surfels;
    const std::vector<std::uint32_t> drawn = drawn_by_area(leaves, static_cast<std::size_t>(options.surfels), options.seed);
    const std::size_t checked = drawn.size();
    const Regions regions(scene.surfels, std::max<std::size_t>(1, checked / checks_per_region));
    const std::vector<Rgb> of_scene = means_of_scene(scene.surfels, solution);
    const SurfelPoints points(leaves);
    const LightSampler lights(scene);
    // Of both halves, first one, then the other of each surfel.
    std::vector<ResidualRays::Sequences> sequences;
    for (std::size_t k = 0; k < 2 * checked; ++k) sequences.emplace_back(options.seed, k);
    std::vector<Gathered> sums(2 * checked, Gathered(regions.count));
    std::atomic<std::size_t> traced{0};
    for (int total = 0, more = least_rays_each;; more = total) {
        parallel_blocks(
            checked, 8,
            [&](std::size_t begin, std::size_t end) {
                ResidualRays rays(scene.surfels, tracer, lights, of_scene, regions, points);
                for (std::size_t k = 2 * begin; k < 2 * end; ++k) {
                    const std::uint32_t i = drawn[k / 2];
                    const Place place{leaves.positions[i], leaves.normals[i], solution.parents[i], i, true};
                    rays.gather(place, more, sequences[k], sums[k]);
                }
                traced += rays.rays;
            },
            progress);
        total += more;
        std::vector<Checked> checks(checked);
        for (std::size_t k = 0; k < checked; ++k) {
            const std::uint32_t i = drawn[k];
            checks[k] = {solution.irradiance[i], regions.of[solution.parents[i]], &sums[2 * k], &sums[2 * k + 1]};
        }
        SelfCheck out = error_of(checks, regions.count, total);
        out.rays = traced;
        if (out.is_enough() || 2 * out.rays > options.most_rays) return out;
    }
}

void check_solution(const Scene& scene, const Tracer& tracer, std::uint64_t seed, const Progress& progress,
                    Solution& solution) {
    Stopwatch watch(solution.timings);
    SelfCheckOptions options;
    options.seed = seed;
    Figures& figures = solution.history.back();
    options.most_rays = std::max(least_rays, static_cast<std::size_t>(most_share * figure(figures, "rays")));
    const SelfCheck check = gathering_error(scene, tracer, solution, options, progress);
    watch.lap("self-check");
    solution.error = check.error;
    figure(figures, "rays") += static_cast<double>(check.rays);
    figure(figures, "error") = check.error;
    figure(figures, "error_uncertainty") = check.uncertainty;
    figure(figures, "seconds") = total_seconds(solution.timings);
}

}  // namespace surflux
