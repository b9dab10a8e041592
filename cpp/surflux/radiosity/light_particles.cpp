#include "surflux/radiosity/light_particles.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"

namespace surflux {

void LightParticles::shoot(const SurfelTree& tree, const Tracer& tracer, const std::vector<double>& sent,
                           std::size_t channels, std::uint64_t seed, const Progress& progress) {
    const std::vector<std::uint32_t> leaves = tree.all_leaves();
    const auto light_of = [&](std::uint32_t p) {
        const double* from = sent.data() + p * channels;
        return channels == 1 ? from[0] : luminance({from[0], from[1], from[2]});
    };
    std::vector<double> power(leaves.size() + 1, 0.0);
    for (std::size_t k = 0; k < leaves.size(); ++k)
        power[k + 1] = power[k] + tree.area(leaves[k]) * std::max(0.0, light_of(leaves[k]));
    arrivals_.clear();
    if (!(power.back() > 0.0)) return;
    const auto wanted = static_cast<std::size_t>(tuning_.particles_of_surfel * static_cast<double>(leaves.size()));
    const std::size_t count =
        std::min(std::max(wanted, whole_number(tuning_.least_particles)), whole_number(tuning_.most_particles));
    power_ = power.back() / static_cast<double>(count);
    std::vector<Arrival> found(count);
    parallel_blocks(
        count, 256,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                Random random(seed, k);
                const double at = (static_cast<double>(k) + random.uniform()) * power_;
                const auto above = std::upper_bound(power.begin() + 1, power.end() - 1, at);
                const std::uint32_t p = leaves[static_cast<std::size_t>(above - power.begin()) - 1];
                const double u = random.uniform(), v = random.uniform();
                const Vec3 way = frame_around(tree.normal(p)).to_world(square_to_cosine_hemisphere(u, v));
                const Hit hit = tracer.closest({{tree.position(p), tree.normal(p), tree.surfel(p)}, way});
                found[k] = {hit && hit.front ? hit.surfel : Hit::none, p, static_cast<float>(light_of(p))};
            }
        },
        progress);
    begin_.assign(tree.points() + 1, 0);
    for (const Arrival& a : found)
        if (a.surfel != Hit::none) ++begin_[a.surfel + 1];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    arrivals_.resize(begin_.back());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (const Arrival& a : found)
        if (a.surfel != Hit::none) arrivals_[next[a.surfel]++] = a;
}

std::vector<double> LightParticles::irradiance(const SurfelTree& tree, const Cut& cut) const {
    std::vector<std::size_t> arrived(cut.nodes.size(), 0);
    for (std::uint32_t s = 0; s + 1 < begin_.size(); ++s)
        if (cut.place_of[s] != SurfelTree::none) arrived[cut.place_of[s]] += begin_[s + 1] - begin_[s];
    const std::size_t telling = whole_number(tuning_.telling_particles);
    std::vector<double> out(cut.nodes.size(), 0.0);
    for (std::size_t k = 0; k < out.size(); ++k)
        if (arrived[k] >= telling) out[k] = static_cast<double>(arrived[k]) * power_ / tree.area(cut.nodes[k]);
    return out;
}

void LightParticles::aims_of(std::uint32_t node, const SurfelTree& tree, const Vec3& at, std::vector<Aim>& out) const {
    const std::size_t before = out.size(), most_aims = static_cast<std::size_t>(std::lround(tuning_.most_aims));
    std::vector<std::uint32_t> stack{node};
    while (!stack.empty() && out.size() < before + most_aims) {
        const std::uint32_t top = stack.back();
        stack.pop_back();
        if (top + 1 < begin_.size())
            for (std::uint32_t a = begin_[top]; a < begin_[top + 1]; ++a) {
                const Vec3 way = tree.position(arrivals_[a].sender) - at;
                const double far = length(way), light = static_cast<double>(arrivals_[a].light);
                if (far > 0.0) out.push_back({way / far, light * power_ / tree.area(node)});
            }
        if (!tree.is_point(top)) tree.for_members(top, [&](std::uint32_t member) { stack.push_back(member); });
    }
}

}  // namespace surflux
