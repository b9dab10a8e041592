#include "surflux/solution/reciprocal_scaling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace surflux {

namespace {

constexpr double least_rays = 256.0;  // that met a group: its factor has a standard error of 6 % at most
constexpr int most_rounds = 50;
constexpr double rounding = 1e-6;   // of shares of hemispheres, as sums of floats
constexpr double tolerance = 1e-4;  // of what is sent, that columns may be off by

// What rays tell of senders: the sum of their weights, and of the squares of these.
struct Evidence {
    double sum = 0.0, squares = 0.0;
    void operator+=(const Evidence& other) { sum += other.sum, squares += other.squares; }
    // As many rays of equal weight have the same relative variance.
    double effective_rays() const { return squares > 0.0 ? sum * sum / squares : 0.0; }
};

// Recursive bisection of senders by position and normal, in which a unit of the normal counts as half the extent.
class Grouping {
public:
    Grouping(const RayExchange& exchange, const std::vector<Evidence>& evidence)
        : exchange_(exchange), evidence_(evidence), group(exchange.sender.size(), 0), order_(exchange.sender.size()) {
        std::iota(order_.begin(), order_.end(), 0u);
        std::stable_sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
            return exchange.sender[a].part < exchange.sender[b].part;
        });
        for (std::size_t first = 0; first < order_.size();) {
            std::size_t last = first + 1;
            while (last < order_.size() && exchange.sender[order_[last]].part == exchange.sender[order_[first]].part)
                ++last;
            divide(first, last);
            first = last;
        }
    }
    std::size_t count() const { return count_; }

private:
    double key(std::uint32_t j, int axis, double extent) const {
        return axis < 3 ? exchange_.sender[j].position[axis] : 0.5 * extent * exchange_.sender[j].normal[axis - 3];
    }

    void divide(std::size_t first, std::size_t last) {
        Evidence all;
        for (std::size_t k = first; k < last; ++k) all += evidence_[order_[k]];
        if (all.effective_rays() >= 2.0 * least_rays && last - first > 1) {
            const std::size_t middle = bisect(first, last);
            Evidence below, above;
            for (std::size_t k = first; k < last; ++k) (k < middle ? below : above) += evidence_[order_[k]];
            if (below.effective_rays() >= least_rays && above.effective_rays() >= least_rays) {
                divide(first, middle);
                divide(middle, last);
                return;
            }
        }
        for (std::size_t k = first; k < last; ++k) group[order_[k]] = static_cast<std::uint32_t>(count_);
        ++count_;
    }

    // Puts one half first.
    std::size_t bisect(std::size_t first, std::size_t last) {
        const auto range = [&](int axis, double extent) {
            double least = std::numeric_limits<double>::infinity(), most = -least;
            for (std::size_t k = first; k < last; ++k) {
                least = std::min(least, key(order_[k], axis, extent));
                most = std::max(most, key(order_[k], axis, extent));
            }
            return most - least;
        };
        double extent = 0.0;
        for (int axis = 0; axis < 3; ++axis) extent = std::max(extent, range(axis, 0.0));
        int widest = 0;
        double width = -1.0;
        for (int axis = 0; axis < 6; ++axis)
            if (const double w = range(axis, extent); w > width) width = w, widest = axis;
        const std::size_t middle = first + (last - first) / 2;
        const auto at = [&](std::size_t k) { return order_.begin() + static_cast<std::ptrdiff_t>(k); };
        std::nth_element(at(first), at(middle), at(last), [&](std::uint32_t a, std::uint32_t b) {
            const double p = key(a, widest, extent), q = key(b, widest, extent);
            return p < q || (p == q && a < b);
        });
        return middle;
    }

    const RayExchange& exchange_;
    const std::vector<Evidence>& evidence_;

public:
    std::vector<std::uint32_t> group;  // of each sender

private:
    std::vector<std::uint32_t> order_;
    std::size_t count_ = 0;
};

struct GroupOfSenders {
    Evidence received;
    double receivers_doubt = 0.0;
    double power = 0.0, sent = 0.0, doubt = 0.0, variance = 0.0;
    double wanted = 0.0, found = 0.0, factor = 1.0;

    // Weight of what is sent, by variances.
    double trust() const {
        if (!(received.sum > 0.0) || !(sent > 0.0)) return 0.0;
        const double noise = received.squares / (received.sum * received.sum);
        const double uncertain = variance / (sent * sent) + doubt * doubt / (sent * sent) +
                                 receivers_doubt * receivers_doubt / (received.sum * received.sum);
        return noise / (noise + uncertain);
    }
    // What all receive, as far as rays have told: the geometric mean of what is sent and what is received.
    double reconciled() const {
        const double weight = trust();
        return weight > 0.0 ? std::min(power, sent * std::pow(received.sum / sent, 1.0 - weight)) : received.sum;
    }
    double lost_scale() const {
        const double lost = power - sent;
        return lost > rounding * power ? std::max(0.0, power - found) / lost : 0.0;
    }
};

}  // namespace

ReciprocalScaling scale_by_reciprocity(const RayExchange& g) {
    const std::size_t rows = g.area.size(), senders = g.sender.size();
    ReciprocalScaling out;
    out.rows.assign(rows, 1.0);
    out.senders.assign(senders, 1.0);
    out.lost.assign(senders, 1.0);
    std::vector<double> weights(rows), received(senders), filled;

    std::vector<Evidence> evidence(senders);
    g.scatter(g.area, received);
    for (std::size_t j = 0; j < senders; ++j) evidence[j].sum = std::max(0.0, g.sender[j].radiosity * received[j]);
    for (std::size_t k = 0; k < rows; ++k) weights[k] = g.area[k] * g.area[k] / std::max(1u, g.rays[k]);
    g.scatter(weights, received);
    for (std::size_t j = 0; j < senders; ++j)
        evidence[j].squares = g.sender[j].radiosity * g.sender[j].radiosity * received[j];
    for (std::size_t k = 0; k < rows; ++k) weights[k] = g.met[k] > 0.0 ? g.area[k] * g.doubt[k] / g.met[k] : 0.0;
    g.scatter(weights, received);
    const Grouping groups(g, evidence);
    out.groups = groups.count();
    out.group = groups.group;
    std::vector<GroupOfSenders> group(out.groups);
    for (std::size_t j = 0; j < senders; ++j) {
        GroupOfSenders& of = group[groups.group[j]];
        const RayExchange::Sender& sender = g.sender[j];
        const double power = sender.radiosity * sender.area;
        of.received += evidence[j];
        of.receivers_doubt += sender.radiosity * received[j];
        of.power += power;
        of.sent += power * sender.met;
        of.doubt += power * sender.doubt;
        of.variance += sender.radiosity * power * sender.variance;
    }
    double all = 0.0;
    for (GroupOfSenders& of : group) {
        of.wanted = of.reconciled();
        out.trust.push_back(of.trust());
        all += of.sent;
    }
    double last = std::numeric_limits<double>::infinity();
    for (;; ++out.rounds) {
        g.gather(out.senders, filled);
        for (std::size_t k = 0; k < rows; ++k) {
            out.rows[k] = filled[k] > 0.0 ? g.met[k] / filled[k] : 0.0;
            weights[k] = g.area[k] * out.rows[k];
        }
        g.scatter(weights, received);
        for (GroupOfSenders& of : group) of.found = 0.0;
        for (std::size_t j = 0; j < senders; ++j)
            group[groups.group[j]].found += g.sender[j].radiosity * out.senders[j] * received[j];
        double off = 0.0;
        for (const GroupOfSenders& of : group) off += std::abs(of.found - of.wanted);
        out.after = all > 0.0 ? off / all : 0.0;
        if (out.rounds == 0) out.before = out.after;
        if (out.after <= tolerance || out.rounds == most_rounds || out.after > 0.95 * last) break;
        last = out.after;
        for (GroupOfSenders& of : group)
            if (of.found > 0.0) of.factor *= of.wanted / of.found;
        for (std::size_t j = 0; j < senders; ++j) out.senders[j] = group[groups.group[j]].factor;
    }
    for (std::size_t j = 0; j < senders; ++j) out.lost[j] = group[groups.group[j]].lost_scale();
    return out;
}

}  // namespace surflux
