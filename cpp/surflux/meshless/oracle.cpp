#include "surflux/meshless/oracle.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double faintest = 1e-6;

// RMS over the surface of a colour's norm by row.
template <class Value>
double rms(const Oracle& of, const Value& of_row) {
    double sum = 0.0, total = 0.0;
    for (std::uint32_t j = 0; j < of.evenly_placed; ++j) {
        const double l = of_row(of.receivers.row(j)), r = of.first_radius[of.basis.object(j)];
        sum += r * r * l * l;
        total += r * r;
    }
    return total > 0.0 ? std::sqrt(sum / total) : 0.0;
}

}  // namespace

// A finer level's receiver may be off by more, half way to where all have the same part in the error: areas are
// 4^-level.
double Oracle::allowed_at(double level) { return std::exp2(0.5 * level); }

Oracle::Wanted Oracle::wanted(double epsilon_e) const {
    const auto all = [&](std::uint32_t row) { return color_norm(rows.values[row]); };
    const auto sent = [&](std::uint32_t row) { return color_norm(rows.values[row] - rows.direct[row]); };
    const auto all_first = [&](std::uint32_t row) { return color_norm(rows.unbounced[row] + rows.first_bounce[row]); };
    const auto sent_first = [&](std::uint32_t row) {
        return color_norm(rows.unbounced[row] + rows.first_bounce[row] - rows.direct[row]);
    };
    const double least = faintest * beside;
    const double of_all = std::max(least, std::min(rms(*this, all), tuning.many_bounces * rms(*this, all_first)));
    const double of_sent = std::max(least, std::min(rms(*this, sent), tuning.many_bounces * rms(*this, sent_first)));
    return {epsilon_e * of_all, epsilon_e * of_sent, epsilon_e * tuning.local_weight, tuning.dimmest * of_all};
}

Oracle::Wanted Oracle::Wanted::at(double light) const {
    const double here = where_dim(light);
    return {std::min(of_all, here), std::min(of_sent, here), local, dimmest};
}

std::vector<std::uint32_t> Oracle::refined(std::size_t level, double epsilon_e) const {
    const std::uint32_t from = basis.first(level), to = level > 0 ? basis.first(level + 1) : evenly_placed;
    const auto all = [&](std::uint32_t row) { return color_norm(rows.values[row]); };
    const auto sent = [&](std::uint32_t row) { return rows.values[row] - rows.direct[row]; };
    const double allowed = allowed_at(static_cast<double>(level));
    const Wanted most = wanted(epsilon_e * allowed);
    std::vector<char> chosen(to - from, 0);
    parallel_blocks(to - from, 64, [&](std::size_t begin, std::size_t end) {
        std::vector<BasisWeight> near;
        for (std::size_t k = begin; k < end; ++k) {
            const auto j = static_cast<std::uint32_t>(from + k);
            if (!receivers.has(j)) continue;
            const std::uint32_t row = receivers.row(j);
            double off = 0.0, off_sent = 0.0;
            if (level > 0) {
                off = color_norm(field.coefficients[j]);
                off_sent = color_norm(field.coefficients[j] - field.direct[j]);
            } else {
                basis.at_level(0, basis.position(j), basis.normal(j), basis.object(j), near);
                for (const BasisWeight& w : near) {
                    const std::uint32_t other = receivers.row(w.function);
                    off = std::max(off, color_norm(rows.values[other] - rows.values[row]));
                    off_sent = std::max(off_sent, color_norm(sent(other) - sent(row)));
                }
            }
            const double uncertain = tuning.significance * noise[row], own = tuning.own_share * epsilon_e * allowed;
            const Wanted here = most.at(all(row));
            chosen[k] = off > std::max(here.of_all, own * all(row)) + uncertain ||
                        off_sent > std::max(here.of_sent, own * color_norm(sent(row))) + uncertain;
        }
    });
    std::vector<std::uint32_t> out;
    for (std::uint32_t k = 0; k < chosen.size(); ++k)
        if (chosen[k]) out.push_back(from + k);
    return out;
}

}  // namespace surflux
