#include "surflux/radiosity/write_leaves.h"

#include "surflux/core/parallel.h"

namespace surflux {

void write_leaves(const SurfelTree& tree, const std::vector<std::uint32_t>& leaves, Solution& out,
                  const Progress& progress) {
    const std::size_t n = leaves.size();
    const Progress at_end = standing_at(n, n, progress);
    out.surfels = tree.surfels_at(leaves, at_end);
    out.parents.resize(n);
    out.radiosity.resize(n);
    const auto write_one = [&](std::size_t k) {
        const std::uint32_t p = leaves[k];
        out.parents[k] = tree.surfel(p);
        out.radiosity[k] = tree.emission(p) + tree.reflectance(p) * out.irradiance[k];
    };
    parallel_for(n, 1024, write_one, at_end);
}

}  // namespace surflux
