#include "surflux/transfer/pack_rows.h"

#include "surflux/core/parallel.h"

namespace surflux {

void pack_rows(ShotRows shot, const std::vector<std::uint32_t>& order, TransportOperator& out) {
    const std::size_t n = order.size();
    out.positions.resize(n);
    out.normals.resize(n);
    out.surfels.resize(n);
    out.rows.resize(n);
    std::uint32_t end = 0;
    for (std::size_t k = 0; k < n; ++k) {
        out.rows[k] = shot.rows[order[k]];
        const std::uint32_t links = out.rows[k].end - out.rows[k].begin;
        out.rows[k].begin = end;
        out.rows[k].end = end += links;
    }
    out.links.resize(end);
    out.slopes.resize(end);
    parallel_for(n, 128, [&](std::size_t k) {
        const std::uint32_t of = order[k];
        out.positions[k] = shot.positions[of];
        out.normals[k] = shot.normals[of];
        out.surfels[k] = shot.surfels[of];
        for (std::uint32_t l = out.rows[k].begin, from = shot.rows[of].begin; l < out.rows[k].end; ++l, ++from) {
            const ShotRows::Link& link = shot.links[from];
            out.links[l] = link.sender << TransportOperator::ray_bits | (link.first + link.second);
            out.slopes[l] = {link.u, link.v};
        }
    });
    out.rays = shot.rays;
}

}  // namespace surflux
