#include "surflux/meshless/surfel_gather.h"

#include <algorithm>
#include <cmath>

namespace surflux {

namespace {

constexpr int least_rays = 64;
constexpr double in_a_row = 16.0;  // surfels that have all rays where so many span the spacing of the coarsest level

}  // namespace

std::vector<MeshlessField::At> gather_on_surfels(const Scene& scene, HemisphereGather& gather,
                                                 const std::vector<std::uint32_t>& surfels,
                                                 const std::vector<double>& spacing, int most_rays,
                                                 const std::vector<Rgb>& coefficients, double gain,
                                                 const Progress& progress) {
    const Surfels& s = scene.surfels;
    std::vector<Place> places;
    std::vector<int> counts;
    for (const std::uint32_t i : surfels) {
        places.push_back({s.positions[i], s.normals[i], i, i});
        const double share = std::min(1.0, in_a_row * std::sqrt(s.areas[i]) / spacing[scene.object[i]]);
        counts.push_back(std::max(std::min(most_rays, least_rays), static_cast<int>(std::lround(most_rays * share))));
    }
    std::vector<Rgb> sent;
    gather.sent(coefficients, sent);
    for (Rgb& rgb : sent)
        for (int c = 0; c < 3; ++c) rgb[c] = std::max(0.0, rgb[c]);
    std::vector<MeshlessField::At> out;
    for (const auto& [row, gathered] : gather.once(places, counts, coefficients, sent, progress)) {
        out.push_back({row.sky + row.emitted, row.sky});
        if (gain > 0.0) out.back().all += gain * (row.first + gathered);
        out.back().clamp();
    }
    return out;
}

}  // namespace surflux
