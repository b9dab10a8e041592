#include "surflux/meshless/meshless_exchange.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/disjoint_sets.h"
#include "surflux/core/parallel.h"

namespace surflux {

MeshlessExchange::MeshlessExchange(const Scene& scene, const MultilevelBasis& basis, const SurfelMeans& means,
                                   const Receivers& receivers, const HemisphereGather& gather, const Progress& progress)
    : scene_(scene), basis_(basis), means_(means), receivers_(receivers), gather_(gather) {
    std::vector<Rgb> values(gather_.size());
    for (std::size_t k = 0; k < values.size(); ++k) {
        const HemisphereGather::Row& row = gather_[k];
        values[k] = {row.escape, row.into_backs, 0.0};
    }
    receivers_.coefficients(values, found_);
    find_parts(progress);
    find_areas();
    losses_.resize(scene_.surfels.size());
    parallel_blocks(
        losses_.size(), 256,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) losses_[i] = loss(static_cast<std::uint32_t>(i));
        },
        progress);
}

void MeshlessExchange::find_areas() {
    std::vector<double> of_coefficients(basis_.size(), 0.0);
    for (std::size_t i = 0; i < scene_.surfels.size(); ++i)
        means_.for_functions(
            i, [&](std::uint32_t j, double weight) { of_coefficients[j] += scene_.surfels.areas[i] * weight; });
    areas_ = receivers_.functional(std::move(of_coefficients));
}

void MeshlessExchange::find_parts(const Progress& progress) {
    const auto rows = static_cast<std::uint32_t>(gather_.size());
    const auto surfels = static_cast<std::uint32_t>(scene_.surfels.size());
    DisjointSets sets(rows + surfels);
    for (std::uint32_t k = 0; k < rows; ++k) {
        report_some(progress, k, rows, 1024);
        gather_.for_senders(k, [&](std::uint32_t i) { sets.join(k, rows + i); });
        gather_.for_links(k, [&](std::uint32_t j) {
            if (receivers_.has(j)) sets.join(k, receivers_.row(j));
        });
        receivers_.for_parents(k, [&](std::uint32_t j) { sets.join(k, receivers_.row(j)); });
    }
    for (std::uint32_t i = 0; i < surfels; ++i) {
        report_some(progress, i, surfels, 16384);
        means_.for_functions(i, [&](std::uint32_t j, double) {
            if (receivers_.has(j)) sets.join(rows + i, receivers_.row(j));
        });
    }
    parts_ = sets.numbered(rows + surfels);
    part_of_surfel_.assign(parts_.begin() + rows, parts_.end());
    parts_.resize(rows);
}

// Calls visit(row, weight) for the receivers of the finest level around a surfel; weights add up to 1.
template <class Visit>
void MeshlessExchange::for_finest_rows(std::uint32_t surfel, const Visit& visit) const {
    std::size_t level = 0;
    double total = 0.0;
    means_.for_functions(surfel, [&](std::uint32_t j, double weight) {
        if (!receivers_.has(j)) return;
        if (basis_.level_of(j) > level) level = basis_.level_of(j), total = 0.0;
        if (basis_.level_of(j) == level) total += weight;
    });
    if (!(total > 0.0)) return;
    means_.for_functions(surfel, [&](std::uint32_t j, double weight) {
        if (receivers_.has(j) && basis_.level_of(j) == level) visit(receivers_.row(j), weight / total);
    });
}

HemisphereLoss MeshlessExchange::loss(std::uint32_t surfel) const {
    HemisphereLoss out;
    const double outside = means_.outside(surfel);
    if (outside == 0.0) return out;
    const Rgb mean = means_.mean(surfel, found_) / outside;
    out.escape = std::clamp(mean.x, 0.0, 1.0);
    out.into_backs = std::clamp(mean.y, 0.0, 1.0 - out.escape);
    double squared = 0.0;
    for_finest_rows(surfel, [&](std::uint32_t row, double weight) {
        const double met = gather_[row].met(), off = met - out.met();
        squared += weight * off * off;
        out.variance += weight * std::max(0.0, areas_[row]) * variance_of_share(met, 1.0 / gather_[row].share);
    });
    out.spread = std::sqrt(squared);
    return out;
}

ReciprocalScaling MeshlessExchange::scale_by_reciprocity(const std::vector<Rgb>& coefficients,
                                                         const Progress& progress) const {
    const Surfels& s = scene_.surfels;
    RayExchange exchange;
    exchange.area = areas_;
    const std::size_t rows = gather_.size();
    exchange.spread.assign(rows, 0.0);
    for (std::size_t k = 0; k < rows; ++k) {
        exchange.met.push_back(gather_[k].share * static_cast<double>(gather_.rays_of(k)));
        exchange.rays.push_back(static_cast<std::uint32_t>(std::lround(1.0 / gather_[k].share)));
    }
    for (std::uint32_t i = 0; i < s.size(); ++i) {
        const double outside = means_.outside(i);
        const Rgb reflected = outside > 0.0 ? s.reflectance[i] * (means_.mean(i, coefficients) / outside) : Rgb{};
        const RayExchange::Sender sender{
            s.positions[i],
            s.normals[i],
            part_of_surfel_[i],
            std::max(0.0, luminance(reflected)) + gather_.exitance(i) + gather_.emission(i),
            gather_.sends(i) ? s.areas[i] * outside : 0.0,
            losses_[i]};
        for_finest_rows(i, [&](std::uint32_t row, double weight) {
            if (areas_[row] > 0.0) exchange.spread[row] += weight * sender.area * sender.loss.spread / areas_[row];
        });
        exchange.sender.push_back(sender);
    }
    exchange.gather = [&](const std::vector<double>& from, std::vector<double>& out) {
        out.resize(rows);
        parallel_for(rows, 64, [&](std::size_t k) {
            double sum = 0.0;
            gather_.for_senders(k, [&](std::uint32_t i) { sum += from[i]; });
            out[k] = gather_[k].share * sum;
        });
    };
    exchange.scatter = [&](const std::vector<double>& weight, std::vector<double>& out) {
        out.resize(s.size());
        parallel_scatter(rows, out, [&](std::size_t k, std::vector<double>& sums) {
            const double each = weight[k] * gather_[k].share;
            gather_.for_senders(k, [&](std::uint32_t i) { sums[i] += each; });
        });
    };
    return surflux::scale_by_reciprocity(exchange, progress);
}

std::vector<double> MeshlessExchange::lit_scale(const ReciprocalScaling& scaling) const {
    const Surfels& s = scene_.surfels;
    std::vector<double> received(scaling.groups, 0.0), sent(scaling.groups, 0.0), out(s.size());
    for (std::size_t k = 0; k < gather_.size(); ++k) {
        double lit = 0.0;
        gather_.for_senders(k, [&](std::uint32_t i) { lit += gather_.exitance(i); });
        if (!(lit > 0.0)) continue;
        // What the row found, shared out among those that its rays over the hemisphere met.
        const double each = areas_[k] * scaling.rows[k] * luminance(gather_[k].first) / lit;
        gather_.for_senders(
            k, [&](std::uint32_t i) { received[scaling.group[i]] += each * scaling.senders[i] * gather_.exitance(i); });
    }
    for (std::uint32_t i = 0; i < s.size(); ++i) {
        const double met = 1.0 - scaling.lost[i] * (losses_[i].escape + losses_[i].into_backs);
        sent[scaling.group[i]] += s.areas[i] * std::max(0.0, met) * gather_.exitance(i);
    }
    for (std::uint32_t i = 0; i < s.size(); ++i) {
        const std::uint32_t group = scaling.group[i];
        const double ratio = received[group] > 0.0 && sent[group] > 0.0 ? sent[group] / received[group] : 1.0;
        out[i] = scaling.senders[i] * std::pow(ratio, scaling.sender_weight[group]);
    }
    return out;
}

Figures MeshlessExchange::power(const Solution& solution) const {
    const Surfels& s = scene_.surfels;
    PowerBalance balance;
    for (std::uint32_t i = 0; i < s.size(); ++i)
        balance.add(part_of_surfel_[i], {s.areas[i], s.reflectance[i], s.emission[i], solution.direct[i],
                                         solution.irradiance[i], losses_[i]});
    return balance.figures();
}

}  // namespace surflux
