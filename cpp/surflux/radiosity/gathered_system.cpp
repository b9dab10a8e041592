#include "surflux/radiosity/gathered_system.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "surflux/core/disjoint_sets.h"
#include "surflux/core/parallel.h"
#include "surflux/solution/gmres.h"

namespace surflux {

namespace {

constexpr std::size_t least_shared_links = 1000000;
const Team alone;

}  // namespace

GatheredSystem::GatheredSystem(const SurfelTree& tree, const Gathering& gathering, const LitPoints& sources,
                               const LightSampler& emitters, std::size_t channels, Team team)
    : tree_(tree),
      gathering_(gathering),
      sources_(sources),
      emitters_(emitters),
      channels_(channels),
      team_(std::move(team)) {}

void GatheredSystem::take_by_nodes(const Cut& cut) {
    cut_ = &cut;
    drop_scaling();
    weights_.clear();
}

void GatheredSystem::interpolate(const Cut& cut, const NodalField& nodes, const std::vector<std::uint32_t>& objects,
                                 const std::vector<double>& x, const Sight& sight, const std::vector<char>& wanted,
                                 const Progress& progress) {
    cut_ = &cut;
    drop_scaling();
    std::vector<Rgb> light(cut.rows.size());
    for (std::size_t k = 0; k < light.size(); ++k) light[k] = value(x, k) + found(k);
    const auto at_leaf = [&](std::size_t k, std::vector<Interpolation::Weight>& near) {
        const auto p = static_cast<std::uint32_t>(k);
        if (!tree_.is_leaf(p)) return;
        const std::uint32_t own = cut.place_of[p];
        if (!wanted.empty() && !wanted[p]) return near.assign(1, {own, 1.0});
        nodes.interpolation().at(tree_.position(p), tree_.normal(p), objects[k], near);
        // Groups span no walls. What was inserted on a patch may lie beyond one from its centre.
        if (!sight.keep_joined(tree_.position(p), tree_.normal(p), nodes.sites(), light, near,
                               tree_.is_inserted(p) ? Sight::none : own))
            near.assign(1, {own, 1.0});
    };
    const auto digest = [&] { return digest_of(light); };
    weights_.fill(tree_.points(), at_leaf, progress, team_, digest);
}

TiltedRgb GatheredSystem::tilted_sky(std::size_t place) const {
    const TiltedRgb& sky = gathering_.sky()[cut_->rows[place]];
    const double scale = row_scale(place);
    return {scale * sky.value, scale * sky.u, scale * sky.v};
}

Rgb GatheredSystem::irradiance(std::uint32_t point, const std::vector<double>& x) const {
    Rgb h = sources_[point];
    for (const Interpolation::Weight& w : weights(point)) h += w.weight * (value(x, w.site) + found(w.site));
    return h;
}

// What nodes send: E + rho (H0 + f + P x), or rho P x alone.
void GatheredSystem::send(const std::vector<double>& x, bool with_sources, const Progress& progress) {
    sent_.resize(tree_.size() * channels_);
    const auto send_one = [&](std::size_t k) {
        const auto p = static_cast<std::uint32_t>(k);
        if (!tree_.is_leaf(p)) return;
        double h[3] = {};
        if (with_sources) {
            const Rgb all = irradiance(p, x);
            for (std::size_t c = 0; c < channels_; ++c) h[c] = all[static_cast<int>(c)];
        } else {
            for (const Interpolation::Weight& w : weights(p))
                for (std::size_t c = 0; c < channels_; ++c) h[c] += w.weight * x[w.site * channels_ + c];
        }
        const double scale = sender_scale_.empty() ? 1.0 : sender_scale_[k];
        const Rgb e = with_sources && !emitters_.samples(tree_.surfel(p)) ? tree_.emission(p) : Rgb{};
        for (std::size_t c = 0; c < channels_; ++c)
            sent_[k * channels_ + c] =
                scale * (e[static_cast<int>(c)] + tree_.reflectance(p)[static_cast<int>(c)] * h[c]);
    };
    parallel_for(tree_.points(), 1024, send_one, progress);
    tree_.pull_up(sent_, channels_);
}

const std::vector<double>& GatheredSystem::sent(const std::vector<double>& x, const Progress& progress) {
    send(x, true, progress);
    return sent_;
}

const std::vector<double>& GatheredSystem::radiosity(const std::vector<double>& x, const Progress& progress) {
    std::vector<double>().swap(sender_scale_);
    send(x, true, progress);
    return sent_;
}

void GatheredSystem::gather(const std::vector<double>& sent, std::size_t channels, std::vector<double>& out) const {
    out.resize(cut_->rows.size() * channels);
    const auto digest = [&] { return digest_of(sent); };
    shared_blocks(
        team(), "gathering of light", digest, cut_->rows.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k)
                gathering_.gather(cut_->rows[k], sent, channels, out.data() + k * channels);
        },
        [&](std::size_t begin, std::size_t end, Packed& to) {
            to.add(out.data() + begin * channels, (end - begin) * channels);
        },
        [&](std::size_t begin, std::size_t end, Unpacking& from) {
            from.take(out.data() + begin * channels, (end - begin) * channels);
        },
        {});
}

const Team& GatheredSystem::team() const { return gathering_.links() < least_shared_links ? alone : team_; }

void GatheredSystem::drop_scaling() {
    row_scale_.clear();
    row_area_.clear();
    part_.clear();
    sender_scale_.clear();
}

// Places of the cut are connected where one is interpolated from at a point that another's rays met.
void GatheredSystem::find_parts(const Progress& progress) {
    const std::size_t places = cut_->rows.size();
    DisjointSets sets(places + tree_.size());
    const auto of_node = [&](std::uint32_t node) { return static_cast<std::uint32_t>(places) + node; };
    std::vector<char> linked(tree_.size(), 0);
    for (std::uint32_t k = 0; k < places; ++k) {
        report_some(progress, k, places, 1024);
        gathering_.for_senders(cut_->rows[k], [&](std::uint32_t sender, double) {
            linked[sender] = 1;
            sets.join(k, of_node(sender));
        });
    }
    std::size_t visited = 0;
    tree_.for_downwards([&](std::uint32_t node) {
        report_some(progress, ++visited, tree_.size(), 1 << 20);
        if (linked[node])
            tree_.for_members(node, [&](std::uint32_t member) {
                linked[member] = 1;
                sets.join(of_node(node), of_node(member));
            });
    });
    for (std::uint32_t p = 0; p < tree_.points(); ++p) {
        report_some(progress, p, tree_.points(), 16384);
        if (tree_.is_leaf(p))
            for (const Interpolation::Weight& w : weights(p)) sets.join(of_node(p), w.site);
    }
    part_ = sets.numbered(places);
}

GatheredSystem::Account GatheredSystem::account(const std::vector<double>& x, const Progress& progress) const {
    constexpr std::size_t grain = 4096;
    std::vector<Account> blocks((tree_.points() + grain - 1) / grain);
    const auto add = [&](std::size_t begin, std::size_t end) {
        Account& of = blocks[begin / grain];
        for (auto p = static_cast<std::uint32_t>(begin); p < end; ++p) {
            if (!tree_.is_leaf(p)) continue;
            const Rgb h = irradiance(p, x), direct = sources_.from_lights(p) + sky(p);
            of.power.add(part(p), {tree_.area(p), tree_.reflectance(p), tree_.emission(p), direct, h, loss(p)});
            of.squared += tree_.area(p) * color_norm(h) * color_norm(h);
            of.area += tree_.area(p);
        }
    };
    parallel_blocks(tree_.points(), grain, add, progress);
    Account all;
    for (const Account& of : blocks) all.power += of.power, all.squared += of.squared, all.area += of.area;
    return all;
}

HemisphereLoss GatheredSystem::loss(std::uint32_t point) const {
    HemisphereLoss out;
    const InterpolationMatrix::Row near = weights(point);
    for (const Interpolation::Weight& w : near) {
        const Gathering::Row& row = gathering_.row(cut_->rows[w.site]);
        out.escape += w.weight * static_cast<double>(row.escape);
        out.into_backs += w.weight * static_cast<double>(row.absorbed);
        const double area = row_area_.empty() ? tree_.area(cut_->nodes[w.site]) : row_area_[w.site];
        out.variance += w.weight * area * variance_of_share(row.met(), row.rays);
    }
    return out;
}

Rgb GatheredSystem::sky(std::uint32_t point) const {
    Rgb sum;
    for (const Interpolation::Weight& w : weights(point)) sum += w.weight * found(w.site);
    return sum;
}

// Interpolation flattens what it is given, most where nodes are far apart beside how fast it changes. What
// interpolating once more takes off says how much, and is given back (twicing, Tukey 1977); what a third time would
// change is the bias that is left.
void GatheredSystem::take_off_bias(const std::vector<std::uint32_t>& leaves, RayExchange& exchange,
                                   const Progress& progress) const {
    std::vector<double> of_leaf(leaves.size()), smooth(row_area_.size());
    // At nodes what interpolation misses, at leaves that interpolated.
    const auto residual = [&](std::vector<double>& at_nodes) {
        const auto add_to_nodes = [&](std::size_t j, std::vector<double>& sums) {
            for (const Interpolation::Weight& w : weights(leaves[j]))
                sums[w.site] += w.weight * tree_.area(leaves[j]) * of_leaf[j] / row_area_[w.site];
        };
        parallel_scatter(leaves.size(), smooth, add_to_nodes, progress);
        for (std::size_t k = 0; k < smooth.size(); ++k) at_nodes[k] -= smooth[k];
        const auto interpolate_one = [&](std::size_t j) {
            of_leaf[j] = 0.0;
            for (const Interpolation::Weight& w : weights(leaves[j])) of_leaf[j] += w.weight * at_nodes[w.site];
        };
        parallel_for(leaves.size(), 1024, interpolate_one, progress);
    };
    for (std::size_t j = 0; j < leaves.size(); ++j) of_leaf[j] = static_cast<double>(exchange.sender[j].met);
    exchange.bias = exchange.met;
    residual(exchange.bias);
    for (std::size_t j = 0; j < leaves.size(); ++j) {
        float& met = exchange.sender[j].met;
        met = std::clamp(met + static_cast<float>(of_leaf[j]), 0.0f, 1.0f);
    }
    std::vector<double> left = exchange.bias;
    residual(left);
    for (std::size_t j = 0; j < leaves.size(); ++j) exchange.sender[j].bias = static_cast<float>(of_leaf[j]);
}

ReciprocalScaling GatheredSystem::scale_by_reciprocity(const std::vector<double>& x, const ReciprocityTuning& tuning,
                                                       const Progress& progress) {
    drop_scaling();
    const std::size_t places = cut_->rows.size();
    const Progress starting = standing_at(0, places, progress);
    send(x, true, starting);
    find_parts(progress);
    const std::vector<std::uint32_t> leaves = tree_.all_leaves();
    row_area_.resize(places);
    const auto add_area = [&](std::size_t j, std::vector<double>& sums) {
        for (const Interpolation::Weight& w : weights(leaves[j])) sums[w.site] += w.weight * tree_.area(leaves[j]);
    };
    parallel_scatter(leaves.size(), row_area_, add_area, starting);
    RayExchange exchange;
    const double unit_area = std::accumulate(row_area_.begin(), row_area_.end(), 0.0);
    const double brightest = *std::max_element(sent_.begin(), sent_.end());
    const double unit_radiosity = static_cast<double>(channels_) * (brightest > 0.0 ? brightest : 1.0);
    exchange.area = row_area_;
    for (double& area : exchange.area) area /= unit_area;
    for (std::size_t k = 0; k < places; ++k) {
        exchange.met.push_back(gathering_.row(cut_->rows[k]).met());
        exchange.rays.push_back(gathering_.row(cut_->rows[k]).rays);
    }
    exchange.sender.resize(leaves.size());
    const auto find_sender = [&](std::size_t j) {
        const std::uint32_t p = leaves[j];
        const HemisphereLoss lost = loss(p);
        double radiosity = 0.0;
        for (std::size_t c = 0; c < channels_; ++c) radiosity += sent_[p * channels_ + c];
        const auto sends = static_cast<float>(radiosity / unit_radiosity);
        exchange.sender[j] = {sends,
                              sends,
                              static_cast<float>(tree_.area(p) / unit_area),
                              static_cast<float>(lost.met()),
                              0.0f,
                              static_cast<float>(lost.variance / unit_area),
                              part(p)};
    };
    parallel_for(leaves.size(), 1024, find_sender, starting);
    take_off_bias(leaves, exchange, starting);
    exchange.place = [&](std::size_t j) {
        return RayExchange::Place{tree_.position(leaves[j]), tree_.normal(leaves[j])};
    };
    std::vector<double>().swap(sent_);  // of all channels: here memory peaks
    std::vector<double> nodes(tree_.size(), 0.0);
    exchange.gather = [&](const std::vector<double>& sent, std::vector<double>& out) {
        parallel_for(leaves.size(), 4096, [&](std::size_t j) { nodes[leaves[j]] = sent[j]; });
        tree_.pull_up(nodes, 1);
        gather(nodes, 1, out);
    };
    // Sums for those nodes alone that rays met.
    std::vector<std::uint32_t> met, number(tree_.size(), 0);
    for (std::size_t k = 0; k < places; ++k)
        gathering_.for_senders(cut_->rows[k], [&](std::uint32_t sender, double) { number[sender] = 1; });
    for (std::uint32_t node = 0; node < number.size(); ++node)
        if (number[node]) {
            number[node] = static_cast<std::uint32_t>(met.size());
            met.push_back(node);
        }
    std::vector<double> of_met(met.size());
    exchange.scatter = [&](const std::vector<double>& weight, std::vector<double>& out) {
        parallel_scatter(places, of_met, [&](std::size_t k, std::vector<double>& sums) {
            gathering_.for_senders(
                cut_->rows[k], [&](std::uint32_t sender, double share) { sums[number[sender]] += weight[k] * share; });
        });
        std::fill(nodes.begin(), nodes.end(), 0.0);
        for (std::size_t k = 0; k < met.size(); ++k) nodes[met[k]] = of_met[k];
        tree_.push_down(nodes);
        parallel_for(leaves.size(), 4096, [&](std::size_t j) { out[j] = nodes[leaves[j]]; });
    };
    ReciprocalScaling scaling = surflux::scale_by_reciprocity(exchange, progress, tuning);
    std::vector<RayExchange::Sender>().swap(exchange.sender);
    sender_scale_.assign(tree_.points(), 1.0);
    for (std::size_t j = 0; j < leaves.size(); ++j) sender_scale_[leaves[j]] = scaling.senders[j];
    row_scale_ = scaling.rows;
    return scaling;
}

LinearReport GatheredSystem::solve(double tolerance, int max_applications, std::vector<double>& x,
                                   const std::vector<double>& unit, const Progress& progress) {
    x.resize(cut_->rows.size() * channels_, 0.0);
    std::vector<double> b;
    const Progress starting = standing_at(0, 100, progress);
    send(std::vector<double>(x.size(), 0.0), true, starting);
    const auto gather_scaled = [&](std::vector<double>& out) {
        gather(sent_, channels_, out);
        if (row_scale_.empty()) return;
        for (std::size_t k = 0; k < out.size(); ++k) out[k] *= row_scale_[k / channels_];
    };
    gather_scaled(b);
    std::size_t told = 0, of = 100;  // what gmres reports between products
    Progress telling, sending;
    if (progress) {
        telling = [&](std::size_t done, std::size_t total) {
            told = done, of = total;
            return progress(done, total);
        };
        sending = [&](std::size_t, std::size_t) { return progress(told, of); };
    }
    const auto in_units = [&](std::size_t k) { return unit.empty() ? 1.0 : unit[k / channels_]; };
    std::vector<double> light(x.size());
    const LinearOperator apply = [&](const std::vector<double>& from, std::vector<double>& out) {
        for (std::size_t k = 0; k < from.size(); ++k) light[k] = from[k] * in_units(k);
        send(light, false, sending);
        gather_scaled(out);
        for (std::size_t k = 0; k < from.size(); ++k) out[k] = from[k] - out[k] / in_units(k);
    };
    for (std::size_t k = 0; k < x.size(); ++k) x[k] /= in_units(k), b[k] /= in_units(k);
    const LinearReport report =
        gmres(apply, b, LinearSystems(channels_, part_), tolerance, max_applications, x, telling);
    for (std::size_t k = 0; k < x.size(); ++k) x[k] *= in_units(k);
    return report;
}

std::vector<Rgb> GatheredSystem::keep_power(const std::vector<Rgb>& as, std::vector<Rgb> light) const {
    std::vector<Rgb> wanted(part_.empty() ? 0 : 1 + *std::max_element(part_.begin(), part_.end())), found = wanted;
    for (std::size_t k = 0; k < part_.size(); ++k) {
        wanted[part_[k]] += row_area_[k] * as[k];
        found[part_[k]] += row_area_[k] * light[k];
    }
    for (std::size_t k = 0; k < part_.size(); ++k)
        for (int c = 0; c < 3; ++c)
            if (found[part_[k]][c] > 0.0) light[k][c] *= wanted[part_[k]][c] / found[part_[k]][c];
    return light;
}

}  // namespace surflux
