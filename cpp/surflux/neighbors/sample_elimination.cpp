#include "surflux/neighbors/sample_elimination.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surflux/core/available_memory.h"
#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/neighbors/candidate_cells.h"
#include "surflux/neighbors/falling_queue.h"

namespace surflux {

namespace {

constexpr std::size_t steps_per_report = 4096;
constexpr double unit = 0x1p40;  // weights are multiples of 1 / unit: their sums up to 2^13 are exact

std::vector<std::uint32_t> eliminated(std::vector<Vec3> points, std::size_t count, double area, std::uint64_t seed,
                                      const Progress& progress) {
    require(count >= 1 && count <= points.size(), "n: wanted between 1 and ", points.size(), " samples, got ", count);
    require(area > 0.0 && std::isfinite(area), "area: wanted a positive number, got ", area);
    for (std::size_t i = 0; i < points.size(); ++i)
        require(is_finite(points[i]), "points: wanted finite coordinates, got others at index ", i);
    const double r_max = std::sqrt(area / (2.0 * std::sqrt(3.0) * static_cast<double>(count)));
    const std::size_t given = points.size(), all = 2 * given - count;  // steps, where none is left out at once
    report(progress, 0, all);
    const auto part = [&](std::size_t from, std::size_t to) -> Progress {
        if (!progress) return {};
        return [&progress, from, to, all](std::size_t done, std::size_t of) {
            return progress(from + (to - from) * done / std::max<std::size_t>(of, 1), all);
        };
    };
    const CandidateCells candidates(std::move(points), 2.0 * r_max, count, seed, part(0, given / 2));
    const std::size_t n = candidates.size(), steps = n - count;

    const double ratio = static_cast<double>(count) / static_cast<double>(n);
    // Yuksel's weight limiting (2015), with his gamma 1.5 and beta .65.
    const double r_min = r_max * (1.0 - std::pow(ratio, 1.5)) * 0.65;
    const auto weight = [&](double squared) {
        const double w = 1.0 - std::max(std::sqrt(squared), 2.0 * r_min) / (2.0 * r_max);
        if (w <= 0.0) return 0.0;
        const double w2 = w * w, w4 = w2 * w2;  // std::pow costs as much as all the rest
        return std::floor(w4 * w4 * unit) / unit;
    };
    std::vector<double> crowding(n, 0.0);
    const auto none = [](std::uint32_t) { return false; };
    parallel_for(
        n, 256,
        [&](std::size_t k) {
            const auto i = static_cast<std::uint32_t>(k);
            candidates.around(i, none, [&](std::uint32_t, double squared) { crowding[i] += weight(squared); });
        },
        part(given / 2, given));

    const auto lot = [&](std::uint32_t i) {
        return std::pair(Random(seed, candidates.point(i)).bits(), candidates.point(i));
    };
    FallingQueue queue(crowding, [&](std::uint32_t i, std::uint32_t j) { return lot(i) > lot(j); });
    std::vector<bool> gone(n, false);
    const auto is_gone = [&](std::uint32_t i) { return gone[i]; };
    for (std::size_t step = 0; step < steps;) {
        const std::uint32_t i = queue.take();
        gone[i] = true;
        candidates.around(i, is_gone, [&](std::uint32_t j, double squared) { crowding[j] -= weight(squared); });
        if (++step % steps_per_report == 0) report(progress, all - steps + step, all);
    }
    report(progress, all, all);
    std::vector<std::uint32_t> kept;
    kept.reserve(count);
    for (std::uint32_t i = 0; i < n; ++i)
        if (!gone[i]) kept.push_back(candidates.point(i));
    std::sort(kept.begin(), kept.end());
    return kept;
}

}  // namespace

std::vector<std::uint32_t> eliminate_samples(std::vector<Vec3> points, std::size_t count, double area,
                                             std::uint64_t seed, const Progress& progress) {
    std::vector<std::uint32_t> kept = eliminated(std::move(points), count, area, seed, progress);
    give_back_memory();  // of the cells of millions of points
    return kept;
}

}  // namespace surflux
