#include "surflux/neighbors/sample_elimination.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

std::vector<std::uint32_t> eliminate_samples(const std::vector<Vec3>& points, std::size_t count, double area,
                                             std::uint64_t seed, const Progress& progress) {
    const std::size_t n = points.size();
    require(count >= 1 && count <= n, "n: wanted between 1 and ", n, " samples, got ", count);
    require(area > 0.0 && std::isfinite(area), "area: wanted a positive number, got ", area);
    const double wanted = static_cast<double>(count), given = static_cast<double>(n);
    const double r_max = std::sqrt(area / (2.0 * std::sqrt(3.0) * wanted));
    const double r_min = r_max * (1.0 - std::pow(wanted / given, 1.5)) * 0.65;
    const auto weight = [&](double distance) {
        const double d = std::max(distance, 2.0 * r_min) / (2.0 * r_max);
        return d >= 1.0 ? 0.0 : std::pow(1.0 - d, 8.0);
    };

    const PointIndex index(points);
    std::vector<std::vector<Neighbor>> crowd(n);
    std::vector<double> crowding(n, 0.0);
    parallel_blocks(
        n, 256,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                index.within(points[i], 2.0 * r_max, crowd[i]);
                crowd[i].erase(
                    std::remove_if(crowd[i].begin(), crowd[i].end(), [i](const Neighbor& c) { return c.index == i; }),
                    crowd[i].end());
                for (const Neighbor& c : crowd[i]) crowding[i] += weight(c.distance);
            }
        },
        progress);

    // A lazy heap: an entry counts only while it holds the point's present crowding.
    using Entry = std::tuple<double, std::uint64_t, std::uint32_t>;
    std::vector<Entry> entries(n);
    for (std::size_t i = 0; i < n; ++i)
        entries[i] = {crowding[i], Random(seed, i).bits(), static_cast<std::uint32_t>(i)};
    std::priority_queue<Entry> heap(std::less<Entry>(), std::move(entries));
    std::vector<bool> gone(n, false);
    for (std::size_t left = n; left > count;) {
        const auto [w, tie, i] = heap.top();
        heap.pop();
        if (gone[i] || w != crowding[i]) continue;
        gone[i] = true;
        --left;
        for (const Neighbor& c : crowd[i]) {
            if (gone[c.index]) continue;
            crowding[c.index] -= weight(c.distance);
            heap.push({crowding[c.index], Random(seed, c.index).bits(), c.index});
        }
    }
    std::vector<std::uint32_t> kept;
    kept.reserve(count);
    for (std::size_t i = 0; i < n; ++i)
        if (!gone[i]) kept.push_back(static_cast<std::uint32_t>(i));
    return kept;
}

}  // namespace surflux
