#include "surflux/radiosity/cut.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/solution/interpolation.h"

namespace surflux {

NodePlaces::NodePlaces(const SurfelTree& tree, const Cut& cut) {
    for (std::uint32_t node : cut.nodes) {
        const std::uint32_t p = tree.representative(node);
        positions.push_back(tree.position(p));
        normals.push_back(tree.normal(p));
        objects.push_back(tree.object(p));
    }
}

void Cut::find_places(const SurfelTree& tree, const Progress& progress) {
    place_of.assign(tree.points(), SurfelTree::none);
    const auto find = [&](std::size_t from, std::size_t to) {
        std::vector<std::uint32_t> stack;
        for (std::size_t k = from; k < to; ++k) {
            stack.push_back(nodes[k]);
            while (!stack.empty()) {
                const std::uint32_t node = stack.back();
                stack.pop_back();
                if (tree.is_point(node)) place_of[node] = static_cast<std::uint32_t>(k);
                tree.for_members(node, [&](std::uint32_t member) { stack.push_back(member); });
            }
        }
    };
    parallel_blocks(nodes.size(), std::max<std::size_t>(1, nodes.size() / 1024), find,
                    standing_at(0, nodes.size(), progress));
}

bool Cut::want(const std::vector<int>& more) {
    rays.resize(nodes.size(), 0);
    bool any = false;
    for (std::size_t k = 0; k < rays.size(); ++k) {
        any = any || more[k] > rays[k];
        rays[k] = std::max(rays[k], more[k]);
    }
    return any;
}

std::size_t Cut::replace(const SurfelTree& tree, const std::vector<char>& chosen, std::vector<double>& values,
                         std::size_t channels, const Progress& progress) {
    std::vector<std::uint32_t> next;
    std::vector<int> wanted;
    std::vector<double> start;
    std::size_t count = 0;
    rays.resize(nodes.size(), 0);
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        const auto keep = [&](std::uint32_t node) {
            next.push_back(node);
            wanted.push_back(static_cast<int>(rays[k] * std::sqrt(tree.area(node) / tree.area(nodes[k]))));
            for (std::size_t c = 0; c < channels; ++c) start.push_back(values[k * channels + c]);
        };
        count += chosen[k] != 0;
        if (chosen[k])
            tree.for_members(nodes[k], keep);
        else
            keep(nodes[k]);
    }
    nodes = std::move(next);
    rays = std::move(wanted);
    values = std::move(start);
    if (count > 0) find_places(tree, progress);
    return count;
}

std::vector<char> Cut::unbalanced(const SurfelTree& tree, const RefinementTuning& tuning,
                                  const Progress& progress) const {
    const NodePlaces at(tree, *this);
    const Interpolation sites(at.positions, at.normals, at.objects, standing_at(0, nodes.size(), progress));
    const std::size_t around = whole_number(tuning.nodes_around);
    const auto fewest_finer = static_cast<std::ptrdiff_t>(whole_number(tuning.fewest_finer));
    std::vector<char> out(nodes.size(), 0);
    parallel_blocks(
        nodes.size(), 64,
        [&](std::size_t from, std::size_t to) {
            std::vector<Interpolation::Weight> near;
            for (std::size_t k = from; k < to; ++k) {
                if (tree.is_leaf(nodes[k])) continue;
                sites.nearest(at.positions[k], at.normals[k], at.objects[k], around, near);
                const double least = tree.area(nodes[k]) / tuning.most_unlike;
                const auto finer = std::count_if(near.begin(), near.end(), [&](const Interpolation::Weight& other) {
                    return tree.area(nodes[other.site]) < least;
                });
                out[k] = finer >= fewest_finer;
            }
        },
        progress);
    return out;
}

}  // namespace surflux
