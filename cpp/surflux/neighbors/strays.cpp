#include "surflux/neighbors/strays.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "surflux/core/disjoint_sets.h"
#include "surflux/core/parallel.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

constexpr std::size_t neighbors = 8, grain = 256;
constexpr double far = 4.0;  // times the distance that is usual around
constexpr std::uint32_t fewest_of_a_surface = 16;

using Near = std::array<std::uint32_t, neighbors>;

}  // namespace

std::vector<char> find_strays(const std::vector<Vec3>& places, const Progress& progress) {
    const std::size_t count = places.size();
    std::vector<char> strays(count, 0);
    if (count <= 4 * neighbors) return strays;
    std::vector<Near> near(count);
    std::vector<float> reach(count), usual(count);
    {
        const PointIndex index(places);
        parallel_blocks(
            count, grain,
            [&](std::size_t begin, std::size_t end) {
                std::vector<Neighbor> found;
                for (std::size_t i = begin; i < end; ++i) {
                    index.nearest(places[i], neighbors + 1, found);
                    std::size_t k = 0;
                    for (const Neighbor& n : found)
                        if (n.index != i && k < neighbors) near[i][k++] = n.index;
                    reach[i] = static_cast<float>(found.back().distance);
                }
            },
            progress);
    }
    parallel_for(count, grain, [&](std::size_t i) {
        std::array<float, neighbors> theirs;
        std::transform(near[i].begin(), near[i].end(), theirs.begin(), [&](std::uint32_t k) { return reach[k]; });
        std::sort(theirs.begin(), theirs.end());
        usual[i] = 0.5f * (theirs[neighbors / 2 - 1] + theirs[neighbors / 2]);
        strays[i] = reach[i] > static_cast<float>(far) * usual[i];
    });
    DisjointSets pieces(count);
    for (std::uint32_t i = 0; i < count; ++i)
        for (const std::uint32_t k : near[i])
            if (length(places[k] - places[i]) <= far * std::min(usual[i], usual[k])) pieces.join(i, k);
    std::vector<std::uint32_t> size(count, 0);
    for (std::uint32_t i = 0; i < count; ++i) ++size[pieces.find(i)];
    for (std::uint32_t i = 0; i < count; ++i)
        if (size[pieces.find(i)] < fewest_of_a_surface) strays[i] = 1;
    return strays;
}

}  // namespace surflux
