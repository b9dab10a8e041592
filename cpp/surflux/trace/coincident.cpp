#include "surflux/trace/coincident.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "surflux/core/place_order.h"
#include "surflux/trace/tracer.h"

namespace surflux {

namespace {

constexpr double opposite = -0.999999;  // cosine of twins' normals
constexpr double alike_radii = 1e-6;    // how far apart theirs may be, over either
constexpr double cell_side = 1.5e-3;    // more than such normals can be apart from opposite ones

class CoincidentFinder {
public:
    explicit CoincidentFinder(const Scene& scene)
        : scene_(scene),
          s_(scene.surfels),
          triangles_(triangle_ranges(s_)),
          out_{std::vector<std::uint32_t>(s_.size(), Hit::none), std::vector<char>(s_.size(), 0)} {}

    Coincident run(const Progress& progress) {
        const std::vector<std::uint32_t> order = place_order(s_.positions, progress);
        for (std::size_t first = 0, last; first < order.size(); first = last) {
            for (last = first + 1; last < order.size() && s_.positions[order[last]] == s_.positions[order[first]];)
                ++last;
            if (last - first < 2) continue;
            const std::vector<std::uint32_t> pile(order.begin() + static_cast<std::ptrdiff_t>(first),
                                                  order.begin() + static_cast<std::ptrdiff_t>(last));
            match(pile, [this](std::uint32_t i) { return std::pair(scene_.object[i], s_.radii[i]); });
            // Radii that are estimated of each object differ by rounding. Whether patches of two objects have the same
            // shape, their sheets tell.
            match(pile, [this](std::uint32_t i) { return std::pair(is_patch(i) ? 1 + scene_.object[i] : 0, 0.0); });
            find_copies(pile);
        }
        return std::move(out_);
    }

private:
    // Normals by cubic cells, so that a pile of thousands costs no more for each than a pair does.
    using Group = std::pair<std::uint32_t, double>;
    struct Cell {
        Group group;
        int x, y, z;
        bool operator<(const Cell& c) const { return std::tie(group, x, y, z) < std::tie(c.group, c.x, c.y, c.z); }
    };
    struct Waiting {
        std::vector<std::uint32_t> surfels;  // ascending
        std::size_t next = 0;                // those before have twins, or have looked for one
    };
    static Cell cell_of(const Group& group, const Vec3& n) {
        const auto at = [](double x) { return static_cast<int>(std::floor(x / cell_side)); };
        return {group, at(n.x), at(n.y), at(n.z)};
    }

    // Each that is free to the first later one of its group that is its back and is free.
    template <class GroupOf>
    void match(const std::vector<std::uint32_t>& pile, const GroupOf& group_of) {
        std::map<Cell, Waiting> cells;
        for (const std::uint32_t i : pile)
            if (out_.twin[i] == Hit::none) cells[cell_of(group_of(i), s_.normals[i])].surfels.push_back(i);
        for (const std::uint32_t i : pile) {
            if (out_.twin[i] != Hit::none) continue;
            const Cell middle = cell_of(group_of(i), -s_.normals[i]);
            std::uint32_t found = Hit::none;
            for (int k = 0; k < 27; ++k) {
                const auto cell =
                    cells.find({middle.group, middle.x + k % 3 - 1, middle.y + k / 3 % 3 - 1, middle.z + k / 9 - 1});
                if (cell == cells.end()) continue;
                Waiting& there = cell->second;
                while (there.next < there.surfels.size() && is_done(there.surfels[there.next], i)) ++there.next;
                for (std::size_t w = there.next; w < there.surfels.size() && there.surfels[w] < found; ++w) {
                    const std::uint32_t j = there.surfels[w];
                    if (!is_done(j, i) && is_back(i, j)) found = j;
                }
            }
            if (found == Hit::none) continue;
            out_.twin[i] = found;
            out_.twin[found] = i;
        }
    }
    bool is_back(std::uint32_t i, std::uint32_t j) const {
        return dot(s_.normals[i], s_.normals[j]) < opposite &&
               std::abs(s_.radii[i] - s_.radii[j]) <= alike_radii * s_.radii[i];
    }
    bool is_patch(std::uint32_t i) const { return triangles_[i] != triangles_[i + 1]; }
    bool is_done(std::uint32_t j, std::uint32_t by) const { return j <= by || out_.twin[j] != Hit::none; }

    void find_copies(std::vector<std::uint32_t> pile) {
        const auto shape = [this](std::uint32_t i) {
            const Vec3& n = s_.normals[i];
            return std::tuple(scene_.object[i], s_.radii[i], n.x, n.y, n.z);
        };
        pile.erase(std::remove_if(pile.begin(), pile.end(), [&](std::uint32_t i) { return is_patch(i); }), pile.end());
        std::sort(pile.begin(), pile.end(),
                  [&](std::uint32_t a, std::uint32_t b) { return shape(a) != shape(b) ? shape(a) < shape(b) : a < b; });
        for (std::size_t k = 1; k < pile.size(); ++k) out_.is_copy[pile[k]] = shape(pile[k]) == shape(pile[k - 1]);
    }

    const Scene& scene_;
    const Surfels& s_;
    std::vector<std::uint32_t> triangles_;
    Coincident out_;
};

}  // namespace

Coincident find_coincident(const Scene& scene, const Progress& progress) {
    return CoincidentFinder(scene).run(progress);
}

}  // namespace surflux
