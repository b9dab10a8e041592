#include "surflux/radiosity/closure.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "surflux/radiosity/symmetric_scaling.h"

namespace surflux {

namespace {

constexpr double near_tolerance = 1e-4;  // of near pairs, whose rows are closed with all others afterwards

// What sure rows lose, such that they close by themselves where that does not contradict the rays.
void settle_losses(const Exchange& exchange, const std::vector<double>& sums, Hemispheres& hemispheres) {
    for (std::size_t i = 0; i < exchange.size; ++i) {
        const double lost = hemispheres.escape[i] + hemispheres.absorbed[i];
        if (!exchange.sure[i] || !(lost > 0.0)) continue;
        // Half a ray, so that one that nearly all or nearly none of them leave has an error too.
        const double rays = hemispheres.taken[i], share = std::clamp(lost, 0.5 / rays, 1.0 - 0.5 / rays);
        const double margin = 3.0 * std::sqrt(share * (1.0 - share) / rays);
        const double wanted =
            std::clamp(1.0 - sums[i] / exchange.areas[i], std::max(0.0, lost - margin), std::min(1.0, lost + margin));
        hemispheres.escape[i] *= wanted / lost;
        hemispheres.absorbed[i] *= wanted / lost;
    }
}

// Scales the near pairs alone, in place.
void scale_near_pairs(Exchange& exchange, const std::vector<double>& sums, const Hemispheres& hemispheres,
                      const PairsTuning& tuning) {
    if (exchange.near.empty()) return;
    std::vector<std::uint32_t> members;
    for (const auto& [i, j] : exchange.near) members.push_back(i), members.push_back(j);
    std::sort(members.begin(), members.end());
    members.erase(std::unique(members.begin(), members.end()), members.end());
    const auto place = [&](std::uint32_t i) {
        return static_cast<std::size_t>(std::lower_bound(members.begin(), members.end(), i) - members.begin());
    };
    struct Entry {
        std::size_t a, b;
        double g;
    };
    std::vector<Entry> entries;
    ScalingProblem problem;
    for (std::uint32_t i : members) {
        problem.totals.push_back(exchange.areas[i]);
        problem.lost.push_back(sums[i] + exchange.areas[i] * (hemispheres.escape[i] + hemispheres.absorbed[i]));
    }
    for (const auto& [i, j] : exchange.near) {
        const Entry entry{place(i), place(j), exchange.at(i, j)};
        problem.lost[entry.a] -= entry.g;
        problem.lost[entry.b] -= entry.g;
        entries.push_back(entry);
    }
    // Subtracting leaves rounding where a row is all near pairs.
    for (double& lost : problem.lost) lost = std::max(lost, 0.0);
    problem.yields.assign(members.size(), tuning.yield_of_rest);
    problem.product = [&](const std::vector<double>& x, std::vector<double>& out) {
        out.assign(x.size(), 0.0);
        for (const Entry& e : entries) {
            out[e.a] += e.g * x[e.b];
            out[e.b] += e.g * x[e.a];
        }
    };
    const Scaling found = scale_symmetrically(problem, tuning.largest_scale, near_tolerance);
    for (std::size_t k = 0; k < entries.size(); ++k) {
        const Entry& e = entries[k];
        exchange.set(exchange.near[k].first, exchange.near[k].second, e.g * found.scale[e.a] * found.scale[e.b]);
    }
}

}  // namespace

Closure close(Exchange& exchange, Hemispheres& hemispheres, const Progress& progress, double tolerance,
              const PairsTuning& tuning) {
    exchange.scale.assign(exchange.size, 1.0);
    const std::vector<double> sums = exchange.row_sums();
    settle_losses(exchange, sums, hemispheres);
    scale_near_pairs(exchange, sums, hemispheres, tuning);

    ScalingProblem problem;
    problem.totals = exchange.areas;
    for (std::size_t i = 0; i < exchange.size; ++i) {
        problem.lost.push_back(exchange.areas[i] * (hemispheres.escape[i] + hemispheres.absorbed[i]));
        problem.yields.push_back(exchange.sure[i] ? 1.0 : tuning.yield_of_disks);
    }
    problem.product = [&](const std::vector<double>& x, std::vector<double>& out) { exchange.apply(x, out, 1); };
    Scaling found = scale_symmetrically(problem, tuning.largest_scale, tolerance, progress);

    Closure closure;
    closure.rounds = found.rounds;
    closure.applications = found.applications + 1;
    for (std::size_t i = 0; i < exchange.size; ++i) {
        const double lacking = 1.0 - found.rows[i];
        hemispheres.escape[i] *= found.lost_scale[i];
        hemispheres.absorbed[i] *= found.lost_scale[i];
        if (lacking > tolerance) {
            hemispheres.absorbed[i] += lacking;
            closure.largest_shortfall = std::max(closure.largest_shortfall, lacking);
            ++closure.short_rows;
        } else {
            closure.residual = std::max(closure.residual, -lacking);
        }
        closure.largest_correction = std::max(closure.largest_correction, std::abs(found.scale[i] - 1.0));
    }
    exchange.scale = std::move(found.scale);
    return closure;
}

}  // namespace surflux
