#include "surflux/transfer/shadow_rays.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"

namespace surflux {

namespace {

constexpr int levels_at_once = 7;  // of the tree, below which subtrees are planned side by side
// Walls make many groups that would send next to nothing. Of those that want less than `certain` of a ray some are
// drawn, and count for the others (Russian roulette, Arvo and Kirk 1990): neighbours by turns, and mostly the same ones
// while a lamp moves.
constexpr double certain = 0.1, least_chance = 0.25, golden_section = 0.6180339887498949;

}  // namespace

std::vector<ShadowRays> plan_shadow_rays(const SenderGroups& groups, const std::vector<float>& power, std::size_t rays,
                                         bool across, std::uint64_t seed,
                                         const std::function<std::size_t(std::uint32_t)>& most_rays) {
    std::vector<ShadowRays> out;
    const double all = groups.size() > 0 ? static_cast<double>(power[0]) : 0.0;
    if (!(all > 0.0)) return out;
    const double offset = Random(seed).uniform(), scale = static_cast<double>(rays) / all;
    const auto wanted_of = [&](std::uint32_t node) { return scale * static_cast<double>(power[node]); };
    const auto fraction = [](double value) { return value - std::floor(value); };
    const auto is_cut = [&](std::uint32_t k) {
        const double wanted = groups.nodes[k].is_leaf() ? 0.0 : wanted_of(k);
        return wanted > 1.0 || (wanted > 0.0 && !across && groups.nodes[k].is_walled());
    };
    const auto add = [&](std::uint32_t k, std::vector<ShadowRays>& shots) {
        const SenderGroups::Node& node = groups.nodes[k];
        const double wanted = wanted_of(k);
        if (wanted == 0.0) return;
        // Of what would share a ray but for a wall.
        const bool is_part_of_one = node.parent != SenderGroups::none && wanted_of(node.parent) <= 1.0;
        const double chance = is_part_of_one ? std::clamp(std::sqrt(wanted / certain), least_chance, 1.0) : 1.0;
        if (chance < 1.0 && fraction(offset + golden_section * static_cast<double>(k)) >= chance) return;
        const std::size_t most = node.is_leaf() ? most_rays(k) : 1;
        const auto count = std::clamp<std::size_t>(static_cast<std::size_t>(wanted), 1, most);
        shots.push_back({k, static_cast<std::uint32_t>(count), static_cast<float>(1.0 / chance)});
    };
    // Subtrees side by side.
    std::vector<std::uint32_t> tops{0};
    for (int level = 0; level < levels_at_once; ++level) {
        std::vector<std::uint32_t> below;
        for (const std::uint32_t k : tops) {
            const std::uint32_t child = groups.nodes[k].child;
            if (is_cut(k))
                below.insert(below.end(), {child, child + 1});
            else
                below.push_back(k);
        }
        tops.swap(below);
    }
    std::vector<std::vector<ShadowRays>> of_tops(tops.size());
    parallel_for(tops.size(), 1, [&](std::size_t top) {
        for (std::vector<std::uint32_t> open{tops[top]}; !open.empty();) {
            const std::uint32_t k = open.back(), child = groups.nodes[k].child;
            open.pop_back();
            if (is_cut(k))
                open.insert(open.end(), {child + 1, child});
            else
                add(k, of_tops[top]);
        }
    });
    for (const std::vector<ShadowRays>& shots : of_tops) out.insert(out.end(), shots.begin(), shots.end());
    return out;
}

}  // namespace surflux
