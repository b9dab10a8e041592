#include "surflux/radiosity/write_leaves.h"

#include "surflux/core/parallel.h"

namespace surflux {

void write_leaves(const SurfelTree& tree, Solution& out, const std::function<LeafLight(std::uint32_t)>& light_of) {
    std::vector<std::uint32_t> leaves;
    tree.for_leaves([&](std::uint32_t p) { leaves.push_back(p); });
    out.surfels = tree.surfels_at(leaves);
    const std::size_t n = leaves.size();
    out.parents.resize(n);
    out.levels.resize(n);
    out.direct.resize(n);
    out.irradiance.resize(n);
    out.radiosity.resize(n);
    parallel_for(n, 256, [&](std::size_t k) {
        const std::uint32_t p = leaves[k];
        const LeafLight light = light_of(p);
        out.parents[k] = tree.surfel(p);
        out.levels[k] = light.level;
        out.direct[k] = light.direct;
        out.irradiance[k] = light.irradiance;
        out.radiosity[k] = tree.emission(p) + tree.reflectance(p) * light.irradiance;
    });
}

}  // namespace surflux
