#include "surflux/radiosity/gathered_system.h"

#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/solution/gmres.h"

namespace surflux {

GatheredSystem::GatheredSystem(const SurfelTree& tree, const Gathering& gathering, const LitPoints& sources,
                               bool emitters_apart, std::size_t channels)
    : tree_(tree), gathering_(gathering), sources_(sources), emitters_apart_(emitters_apart), channels_(channels) {}

void GatheredSystem::take_by_nodes(const Cut& cut) {
    cut_ = &cut;
    const std::size_t n = tree_.points();
    begin_.resize(n + 1);
    weights_.resize(n);
    for (std::size_t p = 0; p <= n; ++p) begin_[p] = p;
    for (std::size_t p = 0; p < n; ++p) weights_[p] = {cut.place_of[p], 1.0};
}

void GatheredSystem::interpolate(const Cut& cut, const NodalField& nodes, const std::vector<std::uint32_t>& objects,
                                 const std::vector<double>& x, const Sight& sight, const std::vector<char>& wanted,
                                 const Progress& progress) {
    cut_ = &cut;
    std::vector<double> light(cut.rows.size());
    for (std::size_t k = 0; k < light.size(); ++k) light[k] = luminance(value(x, k) + found(k));
    constexpr std::size_t grain = 256;
    const std::size_t n = tree_.points();
    std::vector<std::vector<Interpolation::Weight>> blocks((n + grain - 1) / grain);
    begin_.assign(n + 1, 0);
    parallel_blocks(
        n, grain,
        [&](std::size_t from, std::size_t to) {
            std::vector<Interpolation::Weight> near;
            auto& block = blocks[from / grain];
            for (std::size_t k = from; k < to; ++k) {
                const auto p = static_cast<std::uint32_t>(k);
                if (!tree_.is_leaf(p)) continue;
                if (!wanted.empty() && !wanted[p]) {
                    begin_[k + 1] = 1;
                    block.push_back({cut.place_of[p], 1.0});
                    continue;
                }
                nodes.interpolation().at(tree_.position(p), tree_.normal(p), objects[k], near);
                // Groups span no walls. What was inserted on a patch may lie beyond one from its centre.
                const std::uint32_t own = cut.place_of[p];
                if (!sight.keep_joined(tree_.position(p), tree_.normal(p), nodes.positions(), nodes.normals(), light,
                                       near, tree_.is_inserted(p) ? Sight::none : own))
                    near.assign(1, {own, 1.0});
                begin_[k + 1] = near.size();
                block.insert(block.end(), near.begin(), near.end());
            }
        },
        progress);
    weights_.clear();
    for (std::size_t p = 0; p < n; ++p) begin_[p + 1] += begin_[p];
    weights_.reserve(begin_[n]);
    for (const auto& block : blocks) weights_.insert(weights_.end(), block.begin(), block.end());
}

Rgb GatheredSystem::found(std::size_t place) const {
    const std::uint32_t row = cut_->rows[place];
    return gathering_.lamps()[row].value + gathering_.sky()[row].value;
}

Rgb GatheredSystem::irradiance(std::uint32_t point, const std::vector<double>& x) const {
    Rgb h = sources_[point];
    for (std::size_t w = begin_[point]; w < begin_[point + 1]; ++w)
        h += weights_[w].weight * (value(x, weights_[w].site) + found(weights_[w].site));
    return h;
}

// What nodes send: E + rho (H0 + f + P x), or rho P x alone.
void GatheredSystem::send(const std::vector<double>& x, bool with_sources) {
    sent_.resize(tree_.size() * channels_);
    parallel_for(tree_.points(), 1024, [&](std::size_t k) {
        const auto p = static_cast<std::uint32_t>(k);
        if (!tree_.is_leaf(p)) return;
        double h[3] = {};
        if (with_sources) {
            const Rgb all = irradiance(p, x);
            for (std::size_t c = 0; c < channels_; ++c) h[c] = all[static_cast<int>(c)];
        } else {
            for (std::size_t w = begin_[k]; w < begin_[k + 1]; ++w)
                for (std::size_t c = 0; c < channels_; ++c)
                    h[c] += weights_[w].weight * x[weights_[w].site * channels_ + c];
        }
        const Rgb e = with_sources && !emitters_apart_ ? tree_.emission(p) : Rgb{};
        for (std::size_t c = 0; c < channels_; ++c)
            sent_[k * channels_ + c] = e[static_cast<int>(c)] + tree_.reflectance(p)[static_cast<int>(c)] * h[c];
    });
    tree_.pull_up(sent_, channels_);
}

const std::vector<double>& GatheredSystem::sent(const std::vector<double>& x) {
    send(x, true);
    return sent_;
}

void GatheredSystem::gather(std::vector<double>& out) const {
    out.resize(cut_->rows.size() * channels_);
    parallel_for(cut_->rows.size(), 64, [&](std::size_t k) {
        double* to = out.data() + k * channels_;
        gathering_.gather(cut_->rows[k], sent_, channels_, to);
        for (std::size_t c = 0; c < channels_; ++c) to[c] *= gain_;
    });
}

double GatheredSystem::balance(const std::vector<double>& x) {
    send(x, true);
    std::vector<double> arriving;
    const double gain = std::exchange(gain_, 1.0);
    gather(arriving);
    gain_ = gain;
    struct Flux {
        double sent = 0.0, received = 0.0;
        void operator+=(const Flux& other) { sent += other.sent, received += other.received; }
    };
    const Flux all = parallel_sum<Flux>(tree_.points(), 4096, [&](std::size_t k, Flux& flux) {
        const auto p = static_cast<std::uint32_t>(k);
        if (!tree_.is_leaf(p)) return;
        double left = 0.0, received = 0.0;
        for (std::size_t w = begin_[p]; w < begin_[p + 1]; ++w) {
            const Gathering::Row& row = gathering_.row(cut_->rows[weights_[w].site]);
            left += weights_[w].weight * static_cast<double>(row.escape + row.absorbed);
            for (std::size_t c = 0; c < channels_; ++c)
                received += weights_[w].weight * arriving[weights_[w].site * channels_ + c];
        }
        for (std::size_t c = 0; c < channels_; ++c)
            flux.sent += tree_.area(p) * (1.0 - left) * sent_[p * channels_ + c];
        flux.received += tree_.area(p) * received;
    });
    return all.received > 0.0 ? all.sent / all.received : 1.0;
}

LinearReport GatheredSystem::solve(double tolerance, int max_applications, std::vector<double>& x,
                                   const Progress& progress) {
    x.resize(cut_->rows.size() * channels_, 0.0);
    std::vector<double> b;
    send(std::vector<double>(x.size(), 0.0), true);
    gather(b);
    const LinearOperator apply = [&](const std::vector<double>& of, std::vector<double>& out) {
        send(of, false);
        gather(out);
        for (std::size_t k = 0; k < of.size(); ++k) out[k] = of[k] - out[k];
    };
    return gmres(apply, b, channels_, tolerance, max_applications, x, progress);
}

}  // namespace surflux
