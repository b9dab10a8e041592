#include "surflux/meshless/meshless_exchange.h"

#include <algorithm>
#include <cmath>
#include <numeric>

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
        gather_.for_senders(k, [&](std::uint32_t i, double) { sets.join(k, rows + i); });
        gather_.for_links(k, [&](std::uint32_t j) {
            if (receivers_.has(j)) sets.join(k, receivers_.row(j));
        });
    }
    for (std::uint32_t j = 0; j < basis_.size(); ++j)
        receivers_.for_parents(j, [&](std::uint32_t parent, double) {
            if (receivers_.has(parent)) sets.join(receivers_.row(j), receivers_.row(parent));
        });
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
    if (outside == 0.0) {  // in a body, of which it sees the inside
        out.into_backs = 1.0;
        return out;
    }
    const Rgb mean = means_.mean(surfel, found_) / outside;
    out.escape = std::clamp(mean.x, 0.0, 1.0);
    out.into_backs = std::clamp(mean.y, 0.0, 1.0 - out.escape);
    double excess = 0.0;
    for_finest_rows(surfel, [&](std::uint32_t row, double weight) {
        const double met = gather_[row].met(), off = met - out.met();
        const double variance = variance_of_share(met, static_cast<double>(gather_[row].rays));
        excess += weight * (off * off - (1.0 - weight) * variance);
        out.variance += weight * std::max(0.0, areas_[row]) * variance;
    });
    out.bias = std::sqrt(std::max(0.0, excess));
    return out;
}

// By area of what is outside geometry. Wide patches send what lights bring to where a ray ends, any other its mean,
// which is over what lies inside, too.
double MeshlessExchange::per_outside(std::uint32_t surfel, double exitance) const {
    const double outside = means_.outside(surfel);
    return means_.is_wide(surfel) && outside > 0.0 ? exitance / outside : exitance;
}

ReciprocalScaling MeshlessExchange::scale_by_reciprocity(const std::vector<Rgb>& coefficients,
                                                         const ReciprocityTuning& tuning,
                                                         const Progress& progress) const {
    const Surfels& s = scene_.surfels;
    RayExchange exchange;
    const double unit_area = std::accumulate(s.areas.begin(), s.areas.end(), 0.0);
    exchange.area = areas_;
    for (double& area : exchange.area) area /= unit_area;
    const auto carried_by = [&](std::uint32_t i) {
        return std::max(0.0, reflected(i, coefficients)) + gather_.emission(i);
    };
    double brightest = 0.0;
    for (std::uint32_t i = 0; i < s.size(); ++i) brightest = std::max(brightest, carried_by(i) + exitance(i));
    const double unit_radiosity = brightest > 0.0 ? brightest : 1.0;
    const std::size_t rows = gather_.size();
    exchange.bias.assign(rows, 0.0);
    for (std::size_t k = 0; k < rows; ++k) {
        double units = 0.0;
        gather_.for_senders(k, [&](std::uint32_t, double more) { units += more; });
        exchange.met.push_back(gather_[k].share * units);
        exchange.rays.push_back(static_cast<std::uint32_t>(gather_[k].rays));
    }
    for (std::uint32_t i = 0; i < s.size(); ++i) {
        const double outside = means_.outside(i), carried = carried_by(i);
        const RayExchange::Sender sender{static_cast<float>((carried + exitance(i)) / unit_radiosity),
                                         static_cast<float>(carried / unit_radiosity),
                                         gather_.sends(i) ? static_cast<float>(s.areas[i] * outside / unit_area) : 0.0f,
                                         static_cast<float>(losses_[i].met()),
                                         static_cast<float>(losses_[i].bias),
                                         static_cast<float>(losses_[i].variance / unit_area),
                                         part_of_surfel_[i]};
        for_finest_rows(i, [&](std::uint32_t row, double weight) {
            if (exchange.area[row] > 0.0)
                exchange.bias[row] +=
                    weight * static_cast<double>(sender.area) * static_cast<double>(sender.bias) / exchange.area[row];
        });
        exchange.sender.push_back(sender);
    }
    exchange.place = [&](std::size_t i) { return RayExchange::Place{s.positions[i], s.normals[i]}; };
    exchange.gather = [&](const std::vector<double>& from, std::vector<double>& out) {
        out.resize(rows);
        parallel_for(rows, 64, [&](std::size_t k) {
            double sum = 0.0;
            gather_.for_senders(k, [&](std::uint32_t i, double units) { sum += units * from[i]; });
            out[k] = gather_[k].share * sum;
        });
    };
    exchange.scatter = [&](const std::vector<double>& weight, std::vector<double>& out) {
        out.resize(s.size());
        parallel_scatter(rows, out, [&](std::size_t k, std::vector<double>& sums) {
            const double each = weight[k] * gather_[k].share;
            gather_.for_senders(k, [&](std::uint32_t i, double units) { sums[i] += units * each; });
        });
    };
    return surflux::scale_by_reciprocity(exchange, progress, tuning);
}

// Of what a surfel sends of light in the basis, the luminance: less than 0 where functions of several levels are off.
double MeshlessExchange::reflected(std::uint32_t surfel, const std::vector<Rgb>& coefficients) const {
    const double outside = means_.outside(surfel);
    if (outside == 0.0) return 0.0;
    return luminance(scene_.surfels.reflectance[surfel] * means_.mean(surfel, coefficients)) / outside;
}

HemisphereGather::SenderPower MeshlessExchange::sender_power(const ReciprocalScaling& scaling,
                                                             const std::vector<Rgb>& coefficients) const {
    const std::size_t n = scene_.surfels.size(), rows = gather_.size();
    HemisphereGather::SenderPower out;
    std::vector<double> emission(n);
    std::vector<double> exitance_met(scaling.groups, 0.0), exitance_variance(scaling.groups, 0.0),
        emission_met(scaling.groups, 0.0), reflected_met(scaling.groups, 0.0);
    for (std::uint32_t i = 0; i < n; ++i) {
        emission[i] = gather_.emission(i);
        const double carried = reflected(i, coefficients);
        out.radiosity.push_back(std::max(0.0, carried));
        const double area = scene_.surfels.areas[i] * means_.outside(i);
        const double lost = scaling.lost[scaling.group[i]] * (losses_[i].escape + losses_[i].into_backs);
        const double area_met = area * std::max(0.0, 1.0 - lost);
        // Of the sun on roofs, which all leaves, a group may hold more than of the light that `lost` was found by.
        const double area_of_exitance = area * losses_[i].met();
        const double error = area_of_exitance * per_outside(i, gather_.exitance_error(i));
        exitance_met[scaling.group[i]] += area_of_exitance * exitance(i);
        exitance_variance[scaling.group[i]] += error * error;
        emission_met[scaling.group[i]] += area_met * emission[i];
        reflected_met[scaling.group[i]] += area_met * carried;
    }
    std::vector<Rgb> sent;
    gather_.sent(coefficients, sent);
    const std::vector<double> exact(scaling.groups, 0.0);
    const auto factors = [&](const std::vector<double>& wanted, const std::vector<double>& variance,
                             const std::vector<double>& found) {
        std::vector<double> of(n, 1.0);
        for (std::size_t i = 0; i < n; ++i) {
            const std::uint32_t group = scaling.group[i];
            if (wanted[group] > 0.0 && found[group] > 0.0)
                // Between what senders and what receivers say: their geometric mean, weighted by inverse variances.
                of[i] = scaling.bounded(std::pow(
                    wanted[group] / found[group],
                    scaling.variances[group].sender_weight(variance[group] / (wanted[group] * wanted[group]))));
        }
        return of;
    };
    std::vector<double> first(scaling.groups, 0.0);
    for (std::size_t k = 0; k < rows; ++k)
        gather_.for_lit(k, [&](std::uint32_t i, double found) {
            first[scaling.group[i]] += areas_[k] * gather_[k].scale * scaling.senders[i] * found;
        });
    out.exitance = factors(exitance_met, exitance_variance, first);
    // Of each sender's mean what rows have of it is known.
    std::vector<double> emitted(scaling.groups, 0.0), by_means(scaling.groups, 0.0);
    for (std::size_t k = 0; k < rows; ++k) {
        const double each = areas_[k] * gather_[k].share * gather_[k].scale;
        gather_.for_senders(k, [&](std::uint32_t i, double units) {
            emitted[scaling.group[i]] += each * units * scaling.senders[i] * emission[i];
            by_means[scaling.group[i]] += each * units * luminance(sent[i]);
        });
    }
    share_among_wide(scaling, coefficients, sent, reflected_met, by_means);
    out.emitted = factors(emission_met, exact, emitted);
    out.reflected = factors(reflected_met, exact, by_means);
    return out;
}

// Replaces what rows have of groups with wide patches by the same share of what each sends: near rows have the light of
// the places where their rays end, and do not keep whose it is, so that of all such groups of a connected part together
// alone is known what arrives. Shared out by the patches' means, what the lit part of a room sends seemed to come from
// the shaded one as well, which was made a quarter too bright for it.
void MeshlessExchange::share_among_wide(const ReciprocalScaling& scaling, const std::vector<Rgb>& coefficients,
                                        const std::vector<Rgb>& sent, const std::vector<double>& sends,
                                        std::vector<double>& arrived) const {
    std::vector<char> is_wide(scaling.groups, 0);
    std::vector<std::uint32_t> part(scaling.groups, 0);
    std::uint32_t parts = 0;
    for (std::uint32_t i = 0; i < part_of_surfel_.size(); ++i) {
        if (means_.is_wide(i)) is_wide[scaling.group[i]] = 1;
        part[scaling.group[i]] = part_of_surfel_[i];
        parts = std::max(parts, part_of_surfel_[i] + 1);
    }
    if (std::find(is_wide.begin(), is_wide.end(), 1) == is_wide.end()) return;
    for (const std::uint32_t of_row : parts_) parts = std::max(parts, of_row + 1);
    std::vector<double> sent_by_wide(parts, 0.0), arrived_of_wide(parts, 0.0);
    std::vector<double> gathered(gather_.size());
    parallel_for(gathered.size(), 64,
                 [&](std::size_t k) { gathered[k] = luminance(gather_.gather(k, coefficients, sent)); });
    for (std::size_t k = 0; k < gathered.size(); ++k) arrived_of_wide[parts_[k]] += areas_[k] * gathered[k];
    for (std::size_t group = 0; group < scaling.groups; ++group)
        if (is_wide[group])
            sent_by_wide[part[group]] += sends[group];
        else
            arrived_of_wide[part[group]] -= arrived[group];
    for (std::size_t group = 0; group < scaling.groups; ++group)
        if (is_wide[group])
            arrived[group] = sends[group] > 0.0 && sent_by_wide[part[group]] > 0.0
                                 ? sends[group] * arrived_of_wide[part[group]] / sent_by_wide[part[group]]
                                 : 0.0;
}

Figures MeshlessExchange::power(const Solution& solution, const SurfelRefinement& refinement) const {
    const Surfels& s = scene_.surfels;
    std::vector<HemisphereLoss> losses = losses_;
    for (std::size_t k = 0; k < refinement.surfels().size(); ++k) {
        const std::uint32_t i = refinement.surfels()[k];
        if (means_.outside(i) == 1.0) losses[i] = refinement.found()[k].loss;
    }
    PowerBalance balance;
    for (std::uint32_t i = 0; i < s.size(); ++i)
        balance.add(part_of_surfel_[i], {s.areas[i], s.reflectance[i], s.emission[i], solution.direct[i],
                                         solution.irradiance[i], losses[i]});
    return balance.figures();
}

}  // namespace surflux
