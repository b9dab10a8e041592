#include "surflux/radiosity/write_leaves.h"

#include "surflux/core/parallel.h"

namespace surflux {

void write_leaves(const SurfelTree& tree, const std::vector<std::uint32_t>& leaves, Solution& out) {
    out.surfels = tree.surfels_at(leaves);
    const std::size_t n = leaves.size();
    out.parents.resize(n);
    out.radiosity.resize(n);
    parallel_for(n, 256, [&](std::size_t k) {
        const std::uint32_t p = leaves[k];
        out.parents[k] = tree.surfel(p);
        out.radiosity[k] = tree.emission(p) + tree.reflectance(p) * out.irradiance[k];
    });
}

}  // namespace surflux
