#include "surflux/solution/reciprocal_scaling.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr int most_rounds = 50;
constexpr double even = 1e-12;      // relative variance of radiosity within a group that sends about the same
constexpr double rounding = 1e-6;   // of shares of hemispheres, as sums of floats
constexpr double tolerance = 1e-7;  // of what is sent, that columns may be off by

// What rays tell of a sender: the sum of their weights, and of the squares of these.
struct EvidenceOfOne {
    float sum = 0.0f, squares = 0.0f;
};
struct Evidence {
    double sum = 0.0, squares = 0.0;
    void operator+=(const EvidenceOfOne& one) {
        sum += static_cast<double>(one.sum), squares += static_cast<double>(one.squares);
    }
    // As many rays of equal weight have the same relative variance.
    double effective_rays() const { return squares > 0.0 ? sum * sum / squares : 0.0; }
};

// Recursive bisection of senders by position and normal.
class Grouping {
public:
    Grouping(const RayExchange& exchange, const std::vector<EvidenceOfOne>& evidence, const ReciprocityTuning& tuning,
             const Progress& progress)
        : exchange_(exchange),
          evidence_(evidence),
          least_rays_(tuning.rays_of_group),
          progress_(progress),
          group(exchange.sender.size(), 0),
          bisection_(exchange.sender.size(), tuning.normal_weight) {
        std::vector<std::uint32_t>& order = bisection_.order;
        const auto before = [&](std::uint32_t a, std::uint32_t b) {
            return exchange.sender[a].part < exchange.sender[b].part;
        };
        if (!std::is_sorted(order.begin(), order.end(), before)) std::stable_sort(order.begin(), order.end(), before);
        report(progress, 0, order.size());
        for (std::size_t first = 0; first < order.size();) {
            std::size_t last = first + 1;
            while (last < order.size() && exchange.sender[order[last]].part == exchange.sender[order[first]].part)
                ++last;
            divide(first, last);
            first = last;
        }
    }
    std::size_t count() const { return count_; }

private:
    Evidence of(std::size_t first, std::size_t last) const {
        Evidence all;
        for (std::size_t k = first; k < last; ++k) all += evidence_[bisection_.order[k]];
        report(progress_, first, bisection_.order.size());
        return all;
    }

    void divide(std::size_t first, std::size_t last) {
        if (of(first, last).effective_rays() >= 2.0 * least_rays_ && last - first > 1) {
            const std::size_t middle =
                bisection_.halve(first, last, exchange_.place, standing_at(first, bisection_.order.size(), progress_));
            const Evidence below = of(first, middle), above = of(middle, last);
            if (below.effective_rays() >= least_rays_ && above.effective_rays() >= least_rays_) {
                divide(first, middle);
                divide(middle, last);
                return;
            }
        }
        for (std::size_t k = first; k < last; ++k) group[bisection_.order[k]] = static_cast<std::uint32_t>(count_);
        ++count_;
    }

    const RayExchange& exchange_;
    const std::vector<EvidenceOfOne>& evidence_;
    double least_rays_;
    const Progress& progress_;

public:
    std::vector<std::uint32_t> group;  // of each sender

private:
    Bisection bisection_;
    std::size_t count_ = 0;
};

// What a group has of area, or of power: all of it, what senders' own rays say meets fronts, and what all receive.
struct Account {
    double all = 0.0, sent = 0.0, wanted = 0.0, found = 0.0;
    void reconcile(double weight) { wanted = std::min(all, weight * sent + (1.0 - weight) * found); }
};

struct GroupOfSenders {
    std::uint32_t part = 0;
    Evidence received;
    double receivers_bias = 0.0, bias = 0.0, variance = 0.0;
    double power_met = 0.0;  // what of all that it sends meets fronts, by its own rays
    Account area, power;     // of what rows carry
    // What all receive of both, weighted by its senders' scores.
    double scored_area = 0.0, scored_power = 0.0;

    double mean_carried() const { return area.all > 0.0 ? power.all / area.all : 0.0; }
    // Bias is all alike in a group: it adds up.
    ReciprocalScaling::Variances variances() const {
        return {(variance + bias * bias) / (power_met * power_met),
                (received.squares + receivers_bias * receivers_bias) / (received.sum * received.sum)};
    }
    double loss_scale() const {
        const double lost = power.all - power.sent;
        return lost > rounding * power.all ? std::max(0.0, power.all - power.found) / lost : 0.0;
    }
    // By how much a standard deviation more is to be worth, so that senders carry as much as is wanted of their area.
    double tilt() const {
        if (!(power.found > 0.0) || !(area.wanted > 0.0)) return 0.0;
        const double mean = power.wanted / area.wanted, more = scored_power - mean * scored_area;
        const double missing = mean * area.found - power.found;
        return more > even * power.found ? missing / more : std::copysign(1.0, missing);
    }
};

struct Part {
    double sent = 0.0, off = 0.0, last = 0.0;
    bool done = false;  // balanced, or rows leave no more to balance
};

class Balancing {
public:
    Balancing(const RayExchange& exchange, const ReciprocityTuning& tuning, const Progress& progress)
        : g_(exchange), tuning_(tuning), weights_(exchange.area.size()), received_(exchange.sender.size()) {
        out.largest_factor = tuning.largest_factor;
        out.rows.assign(exchange.area.size(), 1.0);
        make_groups(progress);
        out.senders.assign(exchange.sender.size(), 1.0);
        find_scores();
        receive();
        report(progress, 0, most_rounds);
        for (GroupOfSenders& of : groups_) {
            out.variances.push_back(of.variances());
            const double weight = out.variances.back().sender_weight();
            of.area.reconcile(weight);
            of.power.reconcile(weight);
            parts_[of.part].sent += of.power.sent;
        }
    }

    void run(const Progress& progress) {
        for (; !is_done() && rounds_ < most_rounds; ++rounds_) {
            report(progress, static_cast<std::size_t>(rounds_), most_rounds);
            std::vector<double> tilt, area(groups_.size(), 0.0);
            for (const GroupOfSenders& of : groups_) tilt.push_back(parts_[of.part].done ? 0.0 : of.tilt());
            for (std::size_t j = 0; j < out.senders.size(); ++j) {
                const std::uint32_t k = out.group[j];
                const double before = static_cast<double>(tilted_[j]);
                tilted_[j] = static_cast<float>(out.bounded(before * (1.0 + tilt[k] * score(j))));
                out.senders[j] *= static_cast<double>(tilted_[j]) / before;
                area[k] += out.senders[j] * received_[j];
            }
            for (std::size_t j = 0; j < out.senders.size(); ++j) {
                const std::uint32_t k = out.group[j];
                if (!parts_[groups_[k].part].done && area[k] > 0.0)
                    out.senders[j] *= out.bounded(groups_[k].area.wanted / area[k]);
            }
            receive();
        }
        for (const GroupOfSenders& of : groups_) out.lost.push_back(of.loss_scale());
    }

    ReciprocalScaling out;

private:
    // What all receive, with rows scaled to what they are.
    void receive() {
        std::vector<double> filled;
        g_.gather(out.senders, filled);
        for (std::size_t k = 0; k < weights_.size(); ++k) {
            out.rows[k] = 1.0 / (filled[k] + std::max(0.0, 1.0 - g_.met[k]));
            weights_[k] = g_.area[k] * out.rows[k];
        }
        g_.scatter(weights_, received_);
        for (GroupOfSenders& of : groups_) of.area.found = of.power.found = of.scored_area = of.scored_power = 0.0;
        for (std::size_t j = 0; j < received_.size(); ++j) {
            GroupOfSenders& of = groups_[out.group[j]];
            const double carried = static_cast<double>(g_.sender[j].carried), found = out.senders[j] * received_[j];
            of.area.found += found;
            of.power.found += carried * found;
            of.scored_area += score(j) * found;
            of.scored_power += score(j) * carried * found;
        }
    }

    // Standard scores of senders: how far what each carries is from the mean of its group, by what all receive.
    // What no row has met may carry far more than what was: a factor linear in `carried` itself would be without
    // bounds there, and final gathering meets it.
    void find_scores() {
        struct Moments {
            double all = 0.0, carried = 0.0, squared = 0.0;
        };
        std::vector<Moments> moments(groups_.size());
        g_.scatter(g_.area, received_);
        for (std::size_t j = 0; j < received_.size(); ++j) {
            const double carried = static_cast<double>(g_.sender[j].carried), found = std::max(0.0, received_[j]);
            Moments& of = moments[out.group[j]];
            of.all += found, of.carried += carried * found, of.squared += carried * carried * found;
        }
        tilted_.assign(received_.size(), 1.0f);
        score_.assign(received_.size(), 0.0f);
        for (std::size_t j = 0; j < received_.size(); ++j) {
            const Moments& of = moments[out.group[j]];
            if (!(of.carried > 0.0)) continue;
            const double mean = of.carried / of.all, variance = of.squared / of.all - mean * mean;
            if (variance > even * mean * mean)
                score_[j] = static_cast<float>(
                    std::clamp((static_cast<double>(g_.sender[j].carried) - mean) / std::sqrt(variance),
                               -tuning_.largest_score, tuning_.largest_score));
        }
    }
    double score(std::size_t sender) const { return static_cast<double>(score_[sender]); }

    bool is_done() {
        for (Part& part : parts_) part.last = part.off, part.off = 0.0;
        for (const GroupOfSenders& of : groups_)
            parts_[of.part].off += 0.5 * (std::abs(of.power.found - of.power.wanted) +
                                          of.mean_carried() * std::abs(of.area.found - of.area.wanted));
        bool done = true;
        double off = 0.0, sent = 0.0;
        out.after = 0.0;
        for (Part& part : parts_) {
            off += part.off, sent += part.sent;
            part.done = part.done || part.off <= tolerance * part.sent ||
                        (rounds_ > 0 && part.off > tuning_.least_progress * part.last);
            done = done && part.done;
            if (part.sent > 0.0) out.after = std::max(out.after, part.off / part.sent);
        }
        if (rounds_ == 0 && sent > 0.0) out.before = off / sent;
        return done;
    }

    void make_groups(const Progress& progress) {
        const std::size_t rows = g_.area.size(), senders = g_.sender.size();
        std::vector<EvidenceOfOne> evidence(senders);
        const Progress starting = standing_at(0, most_rounds, progress);
        report(starting, 0, 1);
        g_.scatter(g_.area, received_);
        for (std::size_t j = 0; j < senders; ++j) evidence[j].sum = static_cast<float>(std::max(0.0, received_[j]));
        for (std::size_t k = 0; k < rows; ++k) weights_[k] = g_.area[k] * g_.area[k] / std::max(1u, g_.rays[k]);
        g_.scatter(weights_, received_);
        for (std::size_t j = 0; j < senders; ++j) evidence[j].squares = static_cast<float>(std::max(0.0, received_[j]));
        for (std::size_t k = 0; k < rows; ++k)
            weights_[k] = g_.met[k] > 0.0 ? g_.area[k] * g_.bias[k] / g_.met[k] : 0.0;
        report(starting, 0, 1);
        g_.scatter(weights_, received_);
        report(starting, 0, 1);
        Grouping grouping(g_, evidence, tuning_, progress);
        out.groups = grouping.count();
        out.group = std::move(grouping.group);
        groups_.resize(out.groups);
        for (std::size_t j = 0; j < senders; ++j) {
            report_some(starting, j, senders, 1 << 20);
            const RayExchange::Sender& sender = g_.sender[j];
            const auto radiosity = static_cast<double>(sender.radiosity), area = static_cast<double>(sender.area);
            const auto met = static_cast<double>(sender.met);
            const double power = radiosity * area, carried = static_cast<double>(sender.carried) * area;
            GroupOfSenders& of = groups_[out.group[j]];
            of.part = sender.part;
            of.received.sum += radiosity * static_cast<double>(evidence[j].sum);
            of.received.squares += radiosity * radiosity * static_cast<double>(evidence[j].squares);
            of.receivers_bias += radiosity * received_[j];
            of.area.all += area;
            of.area.sent += area * met;
            of.power.all += carried;
            of.power.sent += carried * met;
            of.power_met += power * met;
            of.bias += power * static_cast<double>(sender.bias);
            of.variance += radiosity * power * static_cast<double>(sender.variance);
            if (sender.part >= parts_.size()) parts_.resize(sender.part + 1);
        }
    }

    const RayExchange& g_;
    const ReciprocityTuning& tuning_;
    std::vector<double> weights_, received_;
    std::vector<float> score_, tilted_;  // of each sender
    std::vector<GroupOfSenders> groups_;
    std::vector<Part> parts_;
    int rounds_ = 0;
};

}  // namespace

ReciprocalScaling scale_by_reciprocity(const RayExchange& exchange, const Progress& progress,
                                       const ReciprocityTuning& tuning) {
    Balancing balancing(exchange, tuning, progress);
    balancing.run(progress);
    return std::move(balancing.out);
}

}  // namespace surflux
