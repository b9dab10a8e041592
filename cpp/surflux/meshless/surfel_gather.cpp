#include "surflux/meshless/surfel_gather.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"

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
    const std::size_t first = gather.size();
    gather.add(places, counts, progress);
    std::vector<Rgb> sent;
    if (!coefficients.empty()) gather.sent(coefficients, sent);
    for (Rgb& rgb : sent)
        for (int c = 0; c < 3; ++c) rgb[c] = std::max(0.0, rgb[c]);
    std::vector<MeshlessField::At> out(surfels.size());
    parallel_for(surfels.size(), 64, [&](std::size_t k) {
        const HemisphereGather::Row& row = gather[first + k];
        out[k] = {row.sky + row.emitted, row.sky};
        if (!coefficients.empty()) out[k].all += gain * (row.first + gather.gather(first + k, coefficients, sent));
        out[k].clamp();
    });
    return out;
}

}  // namespace surflux
