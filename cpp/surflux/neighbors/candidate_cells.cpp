#include "surflux/neighbors/candidate_cells.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

// Five candidates for each sample are 1.4 to 2 in an eighth of a cell, where the limit does not bite.
constexpr std::size_t usual_limit = 8;
// A disk of the reach touches some 20 such eighths. Only where the limit had to be raised are there more around.
constexpr std::size_t crowd_limit = 256;
constexpr std::size_t look_limit = 1024;  // in 27 cells; some 100 are usual

// A cell's number along each axis, and in the lowest bits which of its eighths it is: of equal ones all but these are
// in one cell, and cells that follow each other along z have successive ones.
constexpr int axis_bits = 20, eighth_bits = 3;
constexpr std::int64_t most_cells = std::int64_t{1} << axis_bits;

struct Keyed {
    std::uint64_t key;
    std::uint32_t point;
};

// The median of some of the points along each axis: what lies half a million cells away from it, or more, is in the
// outermost ones.
Vec3 middle_of(const std::vector<Vec3>& points) {
    const std::size_t step = points.size() / 4096 + 1;
    Vec3 out;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> some;
        for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i][axis]);
        const auto at = some.begin() + static_cast<std::ptrdiff_t>(some.size() / 2);
        std::nth_element(some.begin(), at, some.end());
        out[axis] = *at;
    }
    return out;
}

std::uint64_t key_of(const Vec3& p, const Vec3& middle, double side) {
    std::uint64_t cell = 0, eighth = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double halves = std::floor((p[axis] - middle[axis]) / (0.5 * side));
        const auto half = static_cast<std::uint64_t>(
            std::clamp(halves + static_cast<double>(most_cells), 0.0, static_cast<double>(2 * most_cells - 1)));
        cell = (cell << axis_bits) | (half >> 1);
        eighth = (eighth << 1) | (half & 1);
    }
    return (cell << eighth_bits) | eighth;
}

std::uint64_t cell_of(std::uint64_t key) { return key >> eighth_bits; }

// Leaves at most so many of those with one key as are `count` in all, but no fewer than usual of each; by lot.
void thin_out(std::vector<Keyed>& sorted, std::size_t count, std::uint64_t seed) {
    const auto for_runs = [&](const auto& visit) {
        for (auto run = sorted.begin(); run != sorted.end();) {
            const auto next =
                std::find_if(run, sorted.end(), [key = run->key](const Keyed& other) { return other.key != key; });
            visit(run, next);
            run = next;
        }
    };
    std::size_t limit = usual_limit, left = 0;
    for (;; limit *= 2) {
        left = 0;
        for_runs([&](auto run, auto next) { left += std::min(limit, static_cast<std::size_t>(next - run)); });
        if (left >= count) break;
    }
    if (left == sorted.size()) return;
    auto end = sorted.begin();
    const auto lot = [&](const Keyed& of) { return std::pair(Random(seed, of.point).bits(), of.point); };
    for_runs([&](auto run, auto next) {
        if (static_cast<std::size_t>(next - run) > limit) {
            const auto last = run + static_cast<std::ptrdiff_t>(limit);
            std::nth_element(run, last, next, [&](const Keyed& a, const Keyed& b) { return lot(a) < lot(b); });
            std::sort(run, last, [](const Keyed& a, const Keyed& b) { return a.point < b.point; });
            next = last;
        }
        end = std::copy(run, next, end);
    });
    sorted.erase(end, sorted.end());
}

}  // namespace

CandidateCells::CandidateCells(std::vector<Vec3> points, double reach, std::size_t count, std::uint64_t seed,
                               const Progress& progress)
    : reach_(reach), squared_reach_(reach * reach) {
    std::vector<std::uint64_t> cells;
    std::vector<std::uint32_t> first;
    {
        std::vector<Keyed> sorted(points.size());
        const Vec3 middle = middle_of(points);
        parallel_for(points.size(), 4096, [&](std::size_t i) {
            sorted[i] = {key_of(points[i], middle, reach), static_cast<std::uint32_t>(i)};
        });
        const auto before = [](const Keyed& a, const Keyed& b) {
            return a.key != b.key ? a.key < b.key : a.point < b.point;
        };
        parallel_sort(sorted, before, progress);
        thin_out(sorted, count, seed);
        point_.resize(sorted.size());
        cell_.resize(sorted.size());
        for (std::uint32_t i = 0; i < sorted.size(); ++i) {
            point_[i] = sorted[i].point;
            if (i == 0 || cell_of(sorted[i - 1].key) != cell_of(sorted[i].key)) {
                cells.push_back(cell_of(sorted[i].key));
                first.push_back(i);
            }
            cell_[i] = static_cast<std::uint32_t>(cells.size() - 1);
        }
        first.push_back(static_cast<std::uint32_t>(sorted.size()));
    }
    places_.resize(point_.size());
    parallel_for(places_.size(), 4096, [&](std::size_t i) { places_[i] = points[point_[i]]; });
    std::vector<Vec3>().swap(points);
    find_rows(cells, first, progress);
    if (!is_dense_.empty()) find_crowds(progress);
}

void CandidateCells::find_rows(const std::vector<std::uint64_t>& cells, const std::vector<std::uint32_t>& first,
                               const Progress& progress) {
    rows_.resize(cells.size());
    std::vector<char> dense(cells.size(), 0);
    constexpr std::uint64_t last = most_cells - 1;
    const auto axis_of = [](std::uint64_t cell, int axis) { return (cell >> ((2 - axis) * axis_bits)) & last; };
    parallel_blocks(
        cells.size(), 4096,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = 0; k < 9; ++k) {
                // Cells ascend, and so do those beside them: each row begins where the last did, or behind.
                std::size_t at = cells.size();
                for (std::size_t c = begin; c < end; ++c) {
                    const std::uint64_t x = axis_of(cells[c], 0) + k / 3, y = axis_of(cells[c], 1) + k % 3,
                                        z = axis_of(cells[c], 2);
                    rows_[c].first[k] = rows_[c].count[k] = 0;
                    if (x < 1 || x > last + 1 || y < 1 || y > last + 1) continue;
                    const std::uint64_t row = ((x - 1) << (2 * axis_bits)) | ((y - 1) << axis_bits);
                    const std::uint64_t from = row | (z > 0 ? z - 1 : 0), to = row | std::min(z + 1, last);
                    if (at == cells.size() || cells[at] > from)
                        at = static_cast<std::size_t>(std::lower_bound(cells.begin(), cells.end(), from) -
                                                      cells.begin());
                    while (at < cells.size() && cells[at] < from) ++at;
                    std::size_t behind = at;
                    while (behind < cells.size() && cells[behind] <= to) ++behind;
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
    const PointIndex index(places_);
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
