#include "surflux/radiosity/local_light.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/core/shared_vectors.h"

namespace surflux {

std::vector<double> local_light(const SurfelTree& tree, const Gathering& gathering, const Cut& cut,
                                const GatheredSystem& system, const std::vector<double>& values, double least,
                                const Progress& progress) {
    // Of all nodes of the tree: the mean irradiance, and then its logarithm.
    std::vector<double> light(tree.size(), 0.0);
    const auto of_leaf = [&](std::size_t k) {
        const auto p = static_cast<std::uint32_t>(k);
        if (tree.is_leaf(p)) light[k] = color_norm(system.irradiance(p, values));
    };
    parallel_for(tree.points(), 1024, of_leaf, progress);
    tree.pull_up(light, 1);
    const auto take_logarithm = [&](std::size_t k) { light[k] = std::log(std::max(least, light[k])); };
    parallel_for(tree.size(), 4096, take_logarithm, progress);
    std::vector<double> out(cut.rows.size());
    const auto at_node = [&](std::size_t k) {
        double sum = 0.0, seen = 0.0;
        gathering.for_senders(cut.rows[k], [&](std::uint32_t sender, double share) {
            sum += share * light[sender];
            seen += share;
        });
        return std::exp(sum + std::max(0.0, 1.0 - seen) * light[cut.nodes[k]]);
    };
    shared_vectors(
        system.team(), "local light", [&] { return digest_of(light); }, 64,
        [&](std::size_t from, std::size_t to) {
            for (std::size_t k = from; k < to; ++k) out[k] = at_node(k);
        },
        progress, out);
    return out;
}

}  // namespace surflux
