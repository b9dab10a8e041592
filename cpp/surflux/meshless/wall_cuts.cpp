#include "surflux/meshless/wall_cuts.h"

#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"

namespace surflux {

std::vector<SupportCut> wall_cuts(const Scene& scene, const Tracer& tracer, const MultilevelBasis& basis,
                                  const BasisSight& sight, const MeshlessTuning& tuning, const Progress& progress) {
    const auto directions = std::lround(tuning.wall_rays);
    const auto most_cuts = static_cast<std::size_t>(std::lround(tuning.most_walls));
    const double height = tuning.wall_height, same_direction = tuning.same_wall;
    const double most_along = std::sqrt(1.0 - tuning.least_wall_slope * tuning.least_wall_slope);
    const std::size_t level = basis.levels() - 1;
    const std::uint32_t first = basis.first(level), last = basis.first(level + 1);
    constexpr std::size_t grain = 64;
    std::vector<std::vector<SupportCut>> blocks((last - first + grain - 1) / grain);
    parallel_blocks(
        last - first, grain,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Ray> rays;
            std::vector<Hit> hits;
            std::vector<BasisWeight> near;
            for (std::size_t k = begin; k < end; ++k) {
                const auto j = static_cast<std::uint32_t>(first + k);
                const double radius = basis.radius(level, j);
                if (!(radius > 0.0)) continue;
                const Vec3 &at = basis.position(j), &normal = basis.normal(j);
                const Frame frame = frame_around(normal);
                rays.clear();
                for (long d = 0; d < directions; ++d) {
                    const double angle = 2.0 * pi * static_cast<double>(d) / static_cast<double>(directions);
                    rays.push_back({{at + (height * radius) * normal, normal, Hit::none},
                                    std::cos(angle) * frame.u + std::sin(angle) * frame.v,
                                    radius});
                }
                tracer.closest(rays, hits);
                std::vector<SupportCut> cuts;
                bool looked = false;
                for (std::size_t d = 0; d < rays.size() && cuts.size() < most_cuts; ++d) {
                    if (!hits[d]) continue;
                    Vec3 wall = scene.surfels.normals[hits[d].surfel];
                    if (std::abs(dot(wall, normal)) > most_along) continue;
                    const double offset = dot(wall, rays[d].from.position + hits[d].distance * rays[d].direction);
                    SupportCut cut{j, wall, offset};
                    if (dot(wall, at) < offset) cut.normal = -1.0 * wall, cut.offset = -offset;
                    bool known = false;
                    for (const SupportCut& other : cuts)
                        known = known || dot(other.normal, cut.normal) > same_direction;
                    if (known) continue;
                    if (!looked) basis.at_level(level, at, normal, basis.object(j), near);
                    looked = true;
                    std::size_t beyond = 0;
                    bool parts = true;
                    for (const BasisWeight& w : near) {
                        const Vec3& other = basis.position(w.function);
                        if (w.function == j || dot(cut.normal, other) >= cut.offset) continue;
                        ++beyond;
                        parts = parts && !sight.joined(j, w.function);
                        if (!parts) break;
                    }
                    if (parts && beyond > 0) cuts.push_back(cut);
                }
                auto& block = blocks[k / grain];
                block.insert(block.end(), cuts.begin(), cuts.end());
            }
        },
        progress);
    std::vector<SupportCut> out;
    for (const auto& block : blocks) out.insert(out.end(), block.begin(), block.end());
    return out;
}

}  // namespace surflux
