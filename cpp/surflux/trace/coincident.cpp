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
            match(pile);
            find_copies(pile);
        }
        return std::move(out_);
    }

private:
    // Normals by cubic cells, so that a pile of thousands costs no more for each than a pair does.
    struct Cell {
        std::uint32_t object;
        double radius;
        int x, y, z;
        bool operator<(const Cell& c) const {
            return std::tie(object, radius, x, y, z) < std::tie(c.object, c.radius, c.x, c.y, c.z);
        }
    };
    struct Waiting {
        std::vector<std::uint32_t> surfels;  // ascending
        std::size_t next = 0;                // those before have twins, or have looked for one
    };
    Cell cell_of(std::uint32_t i, const Vec3& n) const {
        const auto at = [](double x) { return static_cast<int>(std::floor(x / cell_side)); };
        return {scene_.object[i], s_.radii[i], at(n.x), at(n.y), at(n.z)};
    }

    // Each to the first later one that is its back and is free.
    void match(const std::vector<std::uint32_t>& pile) {
        std::map<Cell, Waiting> cells;
        for (const std::uint32_t i : pile) cells[cell_of(i, s_.normals[i])].surfels.push_back(i);
        for (const std::uint32_t i : pile) {
            if (out_.twin[i] != Hit::none) continue;
            const Cell middle = cell_of(i, -s_.normals[i]);
            std::uint32_t found = Hit::none;
            for (int k = 0; k < 27; ++k) {
                const auto cell = cells.find({middle.object, middle.radius, middle.x + k % 3 - 1,
                                              middle.y + k / 3 % 3 - 1, middle.z + k / 9 - 1});
                if (cell == cells.end()) continue;
                Waiting& there = cell->second;
                while (there.next < there.surfels.size() && is_done(there.surfels[there.next], i)) ++there.next;
                for (std::size_t w = there.next; w < there.surfels.size() && there.surfels[w] < found; ++w) {
                    const std::uint32_t j = there.surfels[w];
                    if (!is_done(j, i) && dot(s_.normals[i], s_.normals[j]) < opposite) found = j;
                }
            }
            if (found == Hit::none) continue;
            out_.twin[i] = found;
            out_.twin[found] = i;
        }
    }
    bool is_done(std::uint32_t j, std::uint32_t by) const { return j <= by || out_.twin[j] != Hit::none; }

    void find_copies(std::vector<std::uint32_t> pile) {
        const auto shape = [this](std::uint32_t i) {
            const Vec3& n = s_.normals[i];
            return std::tuple(scene_.object[i], s_.radii[i], n.x, n.y, n.z);
        };
        pile.erase(std::remove_if(pile.begin(), pile.end(),
                                  [&](std::uint32_t i) { return triangles_[i] != triangles_[i + 1]; }),
                   pile.end());
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
