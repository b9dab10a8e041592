#include "surflux/radiosity/local_light.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"

namespace surflux {

std::vector<double> local_light(const SurfelTree& tree, const Gathering& gathering, const Cut& cut,
                                const GatheredSystem& system, const std::vector<double>& values, double least,
                                const Progress& progress) {
    // Logarithms of the mean irradiance of all nodes of the tree.
    std::vector<double> light(tree.size(), 0.0);
    const auto of_leaf = [&](std::size_t k) {
        const auto p = static_cast<std::uint32_t>(k);
        if (tree.is_leaf(p)) light[k] = color_norm(system.irradiance(p, values));
    };
    parallel_for(tree.points(), 1024, of_leaf, progress);
    tree.pull_up(light, 1);
    std::vector<double> out(cut.rows.size());
    const auto of_node = [&](std::size_t k) {
        const std::uint32_t row = cut.rows[k];
        double sum = 0.0, seen = 0.0;
        gathering.for_senders(row, [&](std::uint32_t sender, double share) {
            sum += share * std::log(std::max(least, light[sender]));
            seen += share;
        });
        const double open = std::max(0.0, 1.0 - seen);
        sum += open * std::log(std::max(least, light[cut.nodes[k]]));
        out[k] = std::exp(sum);
    };
    parallel_for(out.size(), 64, of_node, progress);
    return out;
}

}  // namespace surflux
