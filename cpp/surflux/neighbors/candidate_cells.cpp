#include "surflux/neighbors/candidate_cells.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/neighbors/middle.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

// Five candidates for each sample are 1.4 to 2 in an eighth of a cell, where the limit does not bite.
constexpr std::size_t usual_limit = 8;
// Where cells have more than so many in all 27, or `many` in a row of three, the nearest count alone: some 100 are
// usual. In flat ones there are more only where the limit had to be raised.
constexpr std::size_t crowd_limit = 256, look_limit = 1024;
constexpr std::size_t often = 1 << 20;  // between reports

constexpr int axis_bits = 29, eighth_bits = 3;
constexpr std::uint64_t most_cells = std::uint64_t{1} << axis_bits;

// A point by its cell's numbers along x and y, that along z and which eighth of it that it is in.
struct Keyed {
    std::uint64_t xy;
    std::uint32_t z_and_eighth;
    std::uint32_t point;

    std::uint32_t z() const { return z_and_eighth >> eighth_bits; }
    bool in_cell_of(const Keyed& other) const { return xy == other.xy && z() == other.z(); }
    bool in_eighth_of(const Keyed& other) const { return xy == other.xy && z_and_eighth == other.z_and_eighth; }
};

// By the middle of all points: what lies 2^28 cells away from it, or more, is in the outermost ones.
Keyed keyed(const Vec3& p, std::uint32_t point, const Vec3& middle, double side) {
    std::uint64_t cell[3] = {};
    std::uint32_t eighth = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double halves = std::floor((p[axis] - middle[axis]) / (0.5 * side)) + static_cast<double>(most_cells);
        const auto half = static_cast<std::uint64_t>(std::clamp(halves, 0.0, static_cast<double>(2 * most_cells - 1)));
        cell[axis] = half >> 1;
        eighth = (eighth << 1) | static_cast<std::uint32_t>(half & 1);
    }
    return {(cell[0] << axis_bits) | cell[1], (static_cast<std::uint32_t>(cell[2]) << eighth_bits) | eighth, point};
}

// What lies farther out is there, too.
bool is_outermost(const Keyed& of) {
    const auto outermost = [](std::uint64_t cell) { return cell == 0 || cell == most_cells - 1; };
    return outermost(of.xy >> axis_bits) || outermost(of.xy & (most_cells - 1)) || outermost(of.z());
}

// Keeps at most so many of each eighth, by lot: 8, doubled until `count` are left. In the outermost cells all.
void thin_out(std::vector<Keyed>& sorted, std::size_t count, std::uint64_t seed, const Progress& asked) {
    const auto for_eighths = [&](const auto& visit) {
        std::size_t told = 0;
        for (auto first = sorted.begin(), last = first; first != sorted.end(); first = last) {
            while (last != sorted.end() && last->in_eighth_of(*first)) ++last;
            visit(first, last);
            if (const auto done = static_cast<std::size_t>(last - sorted.begin()); done >= told + often)
                report(asked, told = done, sorted.size());
        }
    };
    std::size_t limit = usual_limit, left = 0;
    const auto kept_of = [&](auto first, auto last) {
        const auto all = static_cast<std::size_t>(last - first);
        return is_outermost(*first) ? all : std::min(limit, all);
    };
    for (;; limit *= 2) {
        left = 0;
        for_eighths([&](auto first, auto last) { left += kept_of(first, last); });
        if (left >= count) break;
    }
    if (left == sorted.size()) return;
    auto end = sorted.begin();
    const auto lot = [&](const Keyed& of) { return std::pair(Random(seed, of.point).bits(), of.point); };
    for_eighths([&](auto first, auto last) {
        const auto kept = first + static_cast<std::ptrdiff_t>(kept_of(first, last));
        if (kept != last) {
            std::nth_element(first, kept, last, [&](const Keyed& a, const Keyed& b) { return lot(a) < lot(b); });
            std::sort(first, kept, [](const Keyed& a, const Keyed& b) { return a.point < b.point; });
        }
        end = std::copy(first, kept, end);
    });
    sorted.erase(end, sorted.end());
}

}  // namespace

CandidateCells::CandidateCells(std::vector<Vec3> points, double reach, std::size_t count, std::uint64_t seed,
                               const Progress& progress)
    : reach_(reach), squared_reach_(reach * reach) {
    const std::size_t given = points.size();
    const Progress asked = standing_at(0, given, progress);
    std::vector<Cell> cells;
    std::vector<std::uint32_t> first;
    {
        std::vector<Keyed> sorted(points.size());
        const Vec3 middle = middle_of(points, 4096);
        parallel_for(
            points.size(), 4096,
            [&](std::size_t i) { sorted[i] = keyed(points[i], static_cast<std::uint32_t>(i), middle, reach); }, asked);
        const auto before = [](const Keyed& a, const Keyed& b) {
            if (a.xy != b.xy) return a.xy < b.xy;
            return a.z_and_eighth != b.z_and_eighth ? a.z_and_eighth < b.z_and_eighth : a.point < b.point;
        };
        parallel_sort(sorted, before, asked);
        thin_out(sorted, count, seed, asked);
        point_.resize(sorted.size());
        cell_.resize(sorted.size());
        for (std::uint32_t i = 0; i < sorted.size(); ++i) {
            report_some(asked, i, given, often);
            point_[i] = sorted[i].point;
            if (i == 0 || !sorted[i].in_cell_of(sorted[i - 1])) {
                cells.push_back({sorted[i].xy, sorted[i].z()});
                first.push_back(i);
            }
            cell_[i] = static_cast<std::uint32_t>(cells.size() - 1);
        }
        first.push_back(static_cast<std::uint32_t>(sorted.size()));
    }
    places_.resize(point_.size());
    parallel_for(places_.size(), 4096, [&](std::size_t i) { places_[i] = points[point_[i]]; }, asked);
    std::vector<Vec3>().swap(points);
    find_rows(cells, first, asked);
    if (!is_dense_.empty()) find_crowds(progress);
}

void CandidateCells::find_rows(const std::vector<Cell>& cells, const std::vector<std::uint32_t>& first,
                               const Progress& progress) {
    rows_.resize(cells.size());
    std::vector<char> dense(cells.size(), 0);
    constexpr std::uint64_t last = most_cells - 1;
    parallel_blocks(
        cells.size(), 4096,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = 0; k < 9; ++k) {
                // Cells ascend, and so do those beside them: each row begins where the last did, or behind.
                std::size_t at = cells.size();
                for (std::size_t c = begin; c < end; ++c) {
                    const std::uint64_t x = (cells[c].xy >> axis_bits) + k / 3, y = (cells[c].xy & last) + k % 3;
                    rows_[c].first[k] = rows_[c].count[k] = 0;
                    if (x < 1 || x > last + 1 || y < 1 || y > last + 1) continue;
                    const std::uint64_t xy = ((x - 1) << axis_bits) | (y - 1);
                    const Cell from{xy, std::max(cells[c].z, 1u) - 1}, to{xy, cells[c].z + 1};
                    if (at == cells.size())
                        at = static_cast<std::size_t>(std::lower_bound(cells.begin(), cells.end(), from) -
                                                      cells.begin());
                    while (at < cells.size() && cells[at] < from) ++at;
                    std::size_t behind = at;
                    while (behind < cells.size() && !(to < cells[behind])) ++behind;
                    rows_[c].first[k] = first[at];
                    rows_[c].count[k] = static_cast<std::uint8_t>(std::min(many, first[behind] - first[at]));
                }
            }
            for (std::size_t c = begin; c < end; ++c) {
                std::size_t all = 0, most = 0;
                for (const std::uint8_t count : rows_[c].count) all += count, most = std::max<std::size_t>(most, count);
                dense[c] = most == many || all > look_limit;
            }
        },
        progress);
    if (std::find(dense.begin(), dense.end(), 1) == dense.end()) return;
    is_dense_.resize(places_.size());
    for (std::size_t i = 0; i < places_.size(); ++i) is_dense_[i] = dense[cell_[i]] != 0;
}

const std::vector<std::uint32_t>* CandidateCells::crowd_of(std::uint32_t i) const {
    if (is_dense_.empty() || !is_dense_[i]) return nullptr;
    return &std::lower_bound(crowds_.begin(), crowds_.end(), i, [](const Crowd& crowd, std::uint32_t of) {
                return crowd.of < of;
            })->near;
}

void CandidateCells::find_crowds(const Progress& progress) {
    std::vector<std::uint32_t> number(places_.size(), 0);  // of a dense one's crowd
    for (std::uint32_t i = 0; i < places_.size(); ++i) {
        if (!is_dense_[i]) continue;
        number[i] = static_cast<std::uint32_t>(crowds_.size());
        crowds_.push_back({i, {}});
    }
    const Progress asked = standing_at(0, crowds_.size(), progress);
    const PointIndex index(places_, asked);
    std::vector<std::size_t> own(crowds_.size());
    parallel_blocks(
        crowds_.size(), 256,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near;
            for (std::size_t k = begin; k < end; ++k) {
                auto& [of, crowd] = crowds_[k];
                index.nearest(places_[of], crowd_limit, near, reach_);
                for (const Neighbor& c : near)
                    if (c.index != of) crowd.push_back(c.index);
                std::sort(crowd.begin(), crowd.end());
                own[k] = crowd.size();
            }
        },
        progress);
    // Who is not among the nearest of one that is among its own nearest is near it all the same.
    const auto add = [&](std::uint32_t i, std::uint32_t j) {
        std::vector<std::uint32_t>& crowd = crowds_[number[j]].near;
        const auto end = crowd.begin() + static_cast<std::ptrdiff_t>(own[number[j]]);
        if (!std::binary_search(crowd.begin(), end, i)) crowd.push_back(i);
    };
    for (std::uint32_t i = 0; i < places_.size(); ++i) {
        if (i % often == 0) report(progress, places_.size(), places_.size());
        if (is_dense_[i]) {
            const std::vector<std::uint32_t>& near = crowds_[number[i]].near;
            for (std::size_t k = 0; k < own[number[i]]; ++k)
                if (const std::uint32_t j = near[k]; is_dense_[j]) add(i, j);
        } else {
            const auto sparse = [&](std::uint32_t j) { return !is_dense_[j]; };
            within_reach(i, sparse, [&](std::uint32_t j, double) { add(i, j); });
        }
    }
}

}  // namespace surflux
