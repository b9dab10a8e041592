#include "surflux/transfer/reflections.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "surflux/core/disjoint_sets.h"
#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/solution/gmres.h"

namespace surflux {

namespace {

// Of a residual of the sum of all reflections. The first is what most scenes come to in some bounces; where nearly all
// is reflected, and goes on being, floats hold no more than one of the others.
constexpr double tolerances[] = {1e-5, 1e-4, 1e-3, 1e-2};
constexpr int most_applications = 40;   // for each
constexpr std::size_t most_parts = 15;  // that are solved by themselves
constexpr double dimmest = 1e-3;        // of the RMS: what is dimmer counts as if it were as bright

class Reflections {
public:
    Reflections(const TransportOperator& transport, std::size_t channels, const std::vector<float>& reflectance)
        : transport_(transport),
          senders_(transport.senders),
          channels_(channels),
          unknowns_(channels / colors * 3),
          reflectance_(reflectance) {}

    // Of what nodes send, what leaves receive, by node; what inner nodes send is filled in.
    const std::vector<float>& received(std::vector<float>& sent) {
        if (std::all_of(sent.begin(), sent.end(), [](float value) { return value == 0.0f; })) {
            received_.assign(sent.size(), 0.0f);
            return received_;
        }
        senders_.pull_up(sent, channels_);
        transport_.gather(sent, channels_, values_, TransportOperator::Part::bounces);
        transport_.coefficients(values_, channels_, coefs_, TransportOperator::Part::bounces);
        transport_.receive(coefs_, channels_, received_);
        return received_;
    }

    // visit(at, k, reflectance) for each color of each leaf: its number among those, and of the values by node.
    template <class Visit>
    void for_leaves(const Visit& visit) const {
        parallel_for(senders_.leaves.size(), 2048, [&](std::size_t of_leaf) {
            const std::size_t leaf = senders_.leaves[of_leaf];
            const float* reflectance = reflectance_.data() + colors * leaf;
            std::size_t at = of_leaf * unknowns_;
            for (std::size_t k = leaf * channels_; k < (leaf + 1) * channels_; k += colors)
                for (std::size_t c = 0; c < 3; ++c) visit(at++, k + c, reflectance[c]);
        });
    }

    // Adds so many reflections of what is emitted, and, from the first on, of direct light.
    void add(int bounces, const std::vector<float>& direct, std::vector<float>& all) {
        std::vector<float> sent = all;
        for (int bounce = 0; bounce < bounces; ++bounce) {
            const std::vector<float>& arrived = received(sent);
            const float* more = bounce == 0 ? direct.data() : nullptr;
            parallel_blocks(senders_.leaves.size(), 2048, [&](std::size_t begin, std::size_t end) {
                for (std::size_t of_leaf = begin; of_leaf < end; ++of_leaf)
                    reflect(senders_.leaves[of_leaf], arrived.data(), more, sent.data(), all.data());
            });
        }
    }

    // Of what is sent at first, what is sent with all its reflections: sent = first + reflectance * received(sent).
    // Unknowns are in units of what a leaf sends after one reflection, so that a dim room beside a bright one is solved
    // as well.
    void add_all(const std::vector<float>& first, const std::vector<std::uint32_t>& parts, std::vector<float>& all) {
        std::vector<double> unit(senders_.leaves.size() * unknowns_), right(unit.size()), x;
        std::vector<float> sent = first;
        const std::vector<float>& once = received(sent);
        for_leaves([&](std::size_t at, std::size_t k, float rho) {
            unit[at] = std::abs(static_cast<double>(first[k])) + std::abs(static_cast<double>(rho * once[k]));
        });
        double squares = 0.0;
        for (const double one : unit) squares += one * one;
        if (!(squares > 0.0)) return;
        const double least = dimmest * std::sqrt(squares / static_cast<double>(unit.size()));
        for_leaves([&](std::size_t at, std::size_t k, float) {
            unit[at] = std::max(unit[at], least);
            right[at] = static_cast<double>(first[k]) / unit[at];
        });
        const LinearOperator apply = [&](const std::vector<double>& of, std::vector<double>& to) {
            for_leaves([&](std::size_t at, std::size_t k, float) { sent[k] = static_cast<float>(of[at] * unit[at]); });
            const std::vector<float>& arrived = received(sent);
            to.resize(of.size());
            for_leaves([&](std::size_t at, std::size_t k, float rho) {
                to[at] = of[at] - static_cast<double>(rho * arrived[k]) / unit[at];
            });
        };
        x = right;
        const LinearSystems systems(unknowns_, parts);
        double residual = 1.0;
        for (const double tolerance : tolerances) {
            residual = gmres(apply, right, systems, tolerance, most_applications, x).residual;
            if (residual <= tolerance) break;
        }
        require(residual <= tolerances[3], "bounces: light that is reflected again and again does not come to an end, ",
                "for surfaces that enclose it reflect nearly all of it; wanted a number of bounces");
        for_leaves([&](std::size_t at, std::size_t k, float) { all[k] = static_cast<float>(x[at] * unit[at]); });
    }

private:
    // All four floats of a color at once: the last one is 0.
    void reflect(std::size_t leaf, const float* arrived, const float* more, float* sent, float* all) const {
        float reflectance[colors], of_leaf[colors];
        std::copy_n(reflectance_.data() + colors * leaf, colors, reflectance);
        for (std::size_t k = leaf * channels_; k < (leaf + 1) * channels_; k += colors) {
            for (std::size_t c = 0; c < colors; ++c)
                of_leaf[c] = reflectance[c] * (more != nullptr ? arrived[k + c] + more[k + c] : arrived[k + c]);
            for (std::size_t c = 0; c < colors; ++c) sent[k + c] = of_leaf[c], all[k + c] += of_leaf[c];
        }
    }

    const TransportOperator& transport_;
    const SenderGroups& senders_;
    const std::size_t channels_, unknowns_;  // of each leaf
    const std::vector<float>& reflectance_;
    std::vector<float> values_, coefs_, received_;
};

// The parts of ConnectedLeaves.
std::vector<std::uint32_t> find_parts(const TransportOperator& transport) {
    const SenderGroups& senders = transport.senders;
    const std::vector<SenderGroups::Node>& nodes = senders.nodes;
    DisjointSets sets(senders.size());
    const auto leaf_of_row = [&](std::size_t row) { return senders.leaf_of_surfel[transport.surfels[row]]; };
    std::vector<char> sends(senders.size(), 0);
    for (std::size_t row = 0; row < transport.rows.size(); ++row)
        for (std::uint32_t l = transport.rows[row].begin; l < transport.rows[row].end; ++l) {
            const std::uint32_t sender = TransportOperator::sender(transport.links[l]);
            sets.join(leaf_of_row(row), sender);
            sends[sender] = 1;
        }
    for (std::uint32_t k = 0; k < senders.size(); ++k)  // parents before their children
        if (sends[k] != 0 && !nodes[k].is_leaf())
            for (const std::uint32_t child : {nodes[k].child, nodes[k].child + 1})
                sets.join(k, child), sends[child] = 1;
    for (std::size_t j = 0; j < transport.receiver_of.size(); ++j)
        transport.parents.for_row(j, [&](std::uint32_t parent, float) {
            sets.join(leaf_of_row(transport.receiver_of[j]), leaf_of_row(transport.receiver_of[parent]));
        });
    for (std::size_t k = 0; k < senders.leaves.size(); ++k)
        transport.at_groups.for_row(
            k, [&](std::uint32_t j, float) { sets.join(senders.leaves[k], leaf_of_row(transport.receiver_of[j])); });
    // The largest parts by themselves. Others are few leaves each, or single ones, which nothing reflects to.
    std::map<std::uint32_t, std::size_t> sizes;
    for (const std::uint32_t leaf : senders.leaves) ++sizes[sets.find(leaf)];
    std::vector<std::pair<std::size_t, std::uint32_t>> largest;
    for (const auto& [set, size] : sizes) largest.push_back({size, set});
    std::stable_sort(largest.begin(), largest.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::map<std::uint32_t, std::uint32_t> number;
    for (std::size_t k = 0; k < std::min(largest.size(), most_parts); ++k)
        number[largest[k].second] = static_cast<std::uint32_t>(k);
    std::vector<std::uint32_t> out;
    for (const std::uint32_t leaf : senders.leaves) {
        const auto found = number.find(sets.find(leaf));
        out.push_back(found != number.end() ? found->second : static_cast<std::uint32_t>(most_parts));
    }
    return out;
}

}  // namespace

const std::vector<std::uint32_t>& ConnectedLeaves::of(const TransportOperator& transport) const {
    std::call_once(once_, [&] { parts_ = find_parts(transport); });
    return parts_;
}

std::vector<float> sent_after(int bounces, const TransportOperator& transport, const ConnectedLeaves& connected,
                              std::size_t channels, const std::vector<float>& emission,
                              const std::vector<float>& reflectance, const std::vector<float>& direct) {
    Reflections reflections(transport, channels, reflectance);
    std::vector<float> all = emission;
    if (bounces > 0) {
        reflections.add(bounces, direct, all);
    } else if (bounces < 0) {
        std::vector<float> first = emission;
        reflections.for_leaves([&](std::size_t, std::size_t k, float rho) { first[k] += rho * direct[k]; });
        reflections.add_all(first, connected.of(transport), all);
    }
    transport.senders.pull_up(all, channels);
    return all;
}

}  // namespace surflux
