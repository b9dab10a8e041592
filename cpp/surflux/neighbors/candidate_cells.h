#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

// Points sorted into cubic cells, and renumbered in their order, for passes over what is within reach of each of tens
// of millions: lists of them, which would take most of the memory, are kept for the crowded alone.
class CandidateCells {
public:
    // `reach`: the side of a cell. Where points stand far closer, as near the scanner of a scan, all would be within
    // reach of each other: squares of their number in time and memory. At most a few, by `seed`, of those in an eighth
    // of a cell are candidates, but at least `count` in all. Finite points. Of the progress the crowds are all.
    CandidateCells(std::vector<Vec3> points, double reach, std::size_t count, std::uint64_t seed,
                   const Progress& progress);

    std::size_t size() const { return places_.size(); }
    // Which of the points it is.
    std::uint32_t point(std::uint32_t i) const { return point_[i]; }

    // Calls visit(j, squared distance) for all that are within reach and not to be left out; of very many for the
    // nearest, and those that it is so near to. Who visits is visited.
    template <class LeftOut, class Visit>
    void around(std::uint32_t i, const LeftOut& left_out, const Visit& visit) const {
        if (const std::vector<std::uint32_t>* near = crowd_of(i)) {
            for (const std::uint32_t j : *near)
                if (!left_out(j)) visit(j, length_squared(places_[i] - places_[j]));
            return;
        }
        within_reach(i, left_out, visit);
    }

private:
    // Of the 3 x 3 rows of cells around one, each three cells long: their candidates follow each other.
    struct Rows {
        std::array<std::uint32_t, 9> first;
        std::array<std::uint8_t, 9> count;  // at most `many`
    };
    struct Cell {
        std::uint64_t xy;
        std::uint32_t z;
        bool operator<(const Cell& other) const { return xy != other.xy ? xy < other.xy : z < other.z; }
    };
    struct Crowd {
        std::uint32_t of;
        std::vector<std::uint32_t> near;
    };
    static constexpr std::uint32_t many = 255;

    template <class LeftOut, class Visit>
    void within_reach(std::uint32_t i, const LeftOut& left_out, const Visit& visit) const {
        const Rows& rows = rows_[cell_[i]];
        const Vec3 at = places_[i];
        for (std::size_t k = 0; k < rows.first.size(); ++k)
            for (std::uint32_t j = rows.first[k], end = j + rows.count[k]; j < end; ++j) {
                if (j == i || left_out(j)) continue;
                if (const double squared = length_squared(at - places_[j]); squared < squared_reach_) visit(j, squared);
            }
    }
    const std::vector<std::uint32_t>* crowd_of(std::uint32_t i) const;
    void find_rows(const std::vector<Cell>& cells, const std::vector<std::uint32_t>& first, const Progress& progress);
    void find_crowds(const Progress& progress);

    double reach_, squared_reach_;
    std::vector<Vec3> places_;
    std::vector<std::uint32_t> point_, cell_;
    std::vector<Rows> rows_;      // by cell
    std::vector<bool> is_dense_;  // by candidate; empty where none is
    std::vector<Crowd> crowds_;   // of the dense, ascending
};

}  // namespace surflux
