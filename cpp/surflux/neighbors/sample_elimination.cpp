#include "surflux/neighbors/sample_elimination.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "surflux/core/available_memory.h"
#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/neighbors/distinct_places.h"
#include "surflux/neighbors/falling_queue.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

// Five candidates for each sample are 1.4 to 2 in a cell of side r_max, where the limit does not bite.
constexpr std::uint32_t cell_limit = 8;
// A disk of radius 2 r_max touches some 20 such cells. Only where the limit had to be raised are there more around.
constexpr std::size_t crowd_limit = 256;
constexpr std::size_t look_limit = 1024;  // in 27 cells of side 2 r_max; some 100 are usual
constexpr std::size_t steps_per_report = 4096;

// Where points stand far closer than r_max, as near the scanner of a scan, all would crowd each other: squares of
// their number in time and memory. At most a few at random from each cubic cell of side r_max stand for election,
// but at least `count` in all. Ascending.
std::vector<std::uint32_t> candidates(const std::vector<Vec3>& points, std::size_t count, double r_max,
                                      const std::vector<std::uint64_t>& lots) {
    std::vector<Vec3> corners(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        for (int axis = 0; axis < 3; ++axis) corners[i][axis] = std::floor(points[i][axis] / r_max);
    const DistinctPlaces cells = distinct_places(corners);
    std::vector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0u);
    std::vector<std::uint32_t> in_cell(cells.places.size(), 0);
    for (const std::uint32_t cell : cells.of_point) ++in_cell[cell];
    if (*std::max_element(in_cell.begin(), in_cell.end()) <= cell_limit) return order;
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t i, std::uint32_t j) { return lots[i] != lots[j] ? lots[i] < lots[j] : i < j; });
    std::vector<std::uint32_t> taken(cells.places.size(), 0);
    std::vector<std::uint32_t> rank(points.size());  // in its cell
    for (std::uint32_t i : order) rank[i] = taken[cells.of_point[i]]++;

    std::vector<std::uint32_t> out;
    for (std::uint32_t limit = cell_limit; out.size() < count; limit *= 2) {
        out.clear();
        for (std::uint32_t i = 0; i < points.size(); ++i)
            if (rank[i] < limit) out.push_back(i);
    }
    return out;
}

// Points sorted into cubic cells.
class Cells {
public:
    // Cells of side `reach`, or larger where their numbers would leave the whole numbers of double.
    Cells(const std::vector<Vec3>& points, double reach) : order_(points.size()) {
        Vec3 low = points[0], high = points[0];
        for (const Vec3& p : points)
            for (int axis = 0; axis < 3; ++axis) {
                low[axis] = std::min(low[axis], p[axis]);
                high[axis] = std::max(high[axis], p[axis]);
            }
        const double extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
        const double side = std::max(reach, extent / most_cells);
        std::vector<std::pair<Vec3, std::uint32_t>> sorted(points.size());
        for (std::uint32_t i = 0; i < points.size(); ++i) {
            sorted[i].second = i;
            for (int axis = 0; axis < 3; ++axis)
                sorted[i].first[axis] = std::floor((points[i][axis] - low[axis]) / side);
        }
        std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
            return before(a.first, b.first) || (!before(b.first, a.first) && a.second < b.second);
        });
        for (std::size_t k = 0; k < order_.size(); ++k) {
            order_[k] = sorted[k].second;
            if (k == 0 || before(sorted[k - 1].first, sorted[k].first)) {
                corner_.push_back(sorted[k].first);
                first_.push_back(k);
            }
        }
        first_.push_back(order_.size());
    }

    std::size_t size() const { return corner_.size(); }

    // Calls visit(i) for the points of a cell.
    template <class Visit>
    void in_cell(std::size_t cell, const Visit& visit) const {
        for (std::size_t k = first_[cell]; k < first_[cell + 1]; ++k) visit(order_[k]);
    }

    // The points of a cell and of the 26 around it.
    void around(std::size_t cell, std::vector<std::uint32_t>& out) const {
        out.clear();
        for (double x = -1.0; x <= 1.0; ++x)
            for (double y = -1.0; y <= 1.0; ++y) {
                const Vec3 from = corner_[cell] + Vec3{x, y, -1.0}, to = corner_[cell] + Vec3{x, y, 1.0};
                auto c = static_cast<std::size_t>(std::lower_bound(corner_.begin(), corner_.end(), from, before) -
                                                  corner_.begin());
                for (; c < size() && !before(to, corner_[c]); ++c)
                    in_cell(c, [&](std::uint32_t i) { out.push_back(i); });
            }
    }

private:
    static constexpr double most_cells = 1e12;  // along an axis

    static bool before(const Vec3& a, const Vec3& b) {
        if (a.x != b.x) return a.x < b.x;
        return a.y != b.y ? a.y < b.y : a.z < b.z;
    }

    std::vector<std::uint32_t> order_;
    std::vector<Vec3> corner_;
    std::vector<std::size_t> first_;
};

// Who crowds each point: all within reach, ascending; of more than the limit the nearest, and those that they crowd.
std::vector<std::vector<std::uint32_t>> crowds(const std::vector<Vec3>& places, double reach,
                                               const Progress& progress) {
    const std::size_t n = places.size();
    std::vector<std::vector<std::uint32_t>> crowd(n);
    const Cells cells(places, reach);
    std::vector<std::uint8_t> dense(n, 0);
    const auto half = [&](std::size_t which) -> Progress {
        if (!progress) return progress;
        return [&progress, which](std::size_t done, std::size_t all) { return progress(which * all + done, 2 * all); };
    };
    parallel_blocks(
        cells.size(), 64,
        [&](std::size_t begin, std::size_t end) {
            std::vector<std::uint32_t> around, near;
            for (std::size_t cell = begin; cell < end; ++cell) {
                cells.around(cell, around);
                cells.in_cell(cell, [&](std::uint32_t i) {
                    dense[i] = around.size() > look_limit;
                    if (dense[i]) return;
                    near.clear();
                    for (const std::uint32_t j : around)
                        if (j != i && length_squared(places[i] - places[j]) < reach * reach) near.push_back(j);
                    dense[i] = near.size() >= crowd_limit;
                    if (dense[i]) return;
                    std::sort(near.begin(), near.end());
                    crowd[i] = near;
                });
            }
        },
        half(0));
    if (std::find(dense.begin(), dense.end(), 1) == dense.end()) return crowd;

    const PointIndex index(places);
    std::vector<std::size_t> own(n);
    parallel_blocks(
        n, 256,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near;
            for (std::size_t i = begin; i < end; ++i) {
                if (dense[i]) {
                    index.nearest(places[i], crowd_limit, near, reach);
                    for (const Neighbor& c : near)
                        if (c.index != i) crowd[i].push_back(c.index);
                    std::sort(crowd[i].begin(), crowd[i].end());
                }
                own[i] = crowd[i].size();
            }
        },
        half(1));
    // Who is not among the nearest of one that is among its own nearest still crowds it.
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::size_t k = 0; k < own[i]; ++k) {
            const std::uint32_t j = crowd[i][k];
            const auto end = crowd[j].begin() + static_cast<std::ptrdiff_t>(own[j]);
            if (!std::binary_search(crowd[j].begin(), end, i)) crowd[j].push_back(i);
        }
    return crowd;
}

std::vector<std::uint32_t> eliminated(const std::vector<Vec3>& points, std::size_t count, double area,
                                      std::uint64_t seed, const Progress& progress) {
    require(count >= 1 && count <= points.size(), "n: wanted between 1 and ", points.size(), " samples, got ", count);
    require(area > 0.0 && std::isfinite(area), "area: wanted a positive number, got ", area);
    std::vector<std::uint64_t> lots(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) lots[i] = Random(seed, i).bits();
    const double r_max = std::sqrt(area / (2.0 * std::sqrt(3.0) * static_cast<double>(count)));
    const std::vector<std::uint32_t> stand = candidates(points, count, r_max, lots);
    const std::size_t n = stand.size();
    report(progress, 0, 2 * n - count);
    std::vector<Vec3> places(n);
    for (std::size_t i = 0; i < n; ++i) places[i] = points[stand[i]];

    const double ratio = static_cast<double>(count) / static_cast<double>(n);
    // Yuksel's weight limiting (2015), with his gamma 1.5 and beta .65.
    const double r_min = r_max * (1.0 - std::pow(ratio, 1.5)) * 0.65;
    const auto weight = [&](std::size_t i, std::size_t j) {
        const double w = 1.0 - std::max(length(places[i] - places[j]), 2.0 * r_min) / (2.0 * r_max);
        if (w <= 0.0) return 0.0;
        const double w2 = w * w, w4 = w2 * w2;  // std::pow costs as much as all the rest
        return w4 * w4;
    };
    const std::size_t steps = n - count;
    const Progress gathering = [&](std::size_t done, std::size_t all) {
        return progress(n * done / std::max<std::size_t>(all, 1), n + steps);
    };
    const std::vector<std::vector<std::uint32_t>> crowd = crowds(places, 2.0 * r_max, progress ? gathering : progress);
    std::vector<double> crowding(n, 0.0);
    const Progress weighing = [&](std::size_t, std::size_t) { return progress(n, n + steps); };
    parallel_blocks(
        n, 256,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                for (std::uint32_t j : crowd[i]) crowding[i] += weight(i, j);
        },
        progress ? weighing : progress);

    const auto wins = [&](std::uint32_t i, std::uint32_t j) {
        return lots[stand[i]] != lots[stand[j]] ? lots[stand[i]] > lots[stand[j]] : i > j;
    };
    FallingQueue queue(crowding, wins);
    std::vector<bool> gone(n, false);
    for (std::size_t step = 0; step < steps;) {
        const std::uint32_t i = queue.take();
        gone[i] = true;
        for (std::uint32_t j : crowd[i])
            if (!gone[j]) crowding[j] -= weight(i, j);
        if (++step % steps_per_report == 0) report(progress, n + step, n + steps);
    }
    std::vector<std::uint32_t> kept;
    kept.reserve(count);
    for (std::size_t i = 0; i < n; ++i)
        if (!gone[i]) kept.push_back(stand[i]);
    return kept;
}

}  // namespace

std::vector<std::uint32_t> eliminate_samples(const std::vector<Vec3>& points, std::size_t count, double area,
                                             std::uint64_t seed, const Progress& progress) {
    std::vector<std::uint32_t> kept = eliminated(points, count, area, seed, progress);
    give_back_memory();  // of the lists of millions of points
    return kept;
}

}  // namespace surflux
