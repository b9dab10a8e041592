#include "surflux/trace/facing.h"

#include <algorithm>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/neighbors/distinct_places.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

constexpr std::size_t followed = 6;  // places looked at whose points one beside them follows
constexpr double alike = 0.5;        // cosine between its normal and theirs; else, any that faces its way
constexpr std::size_t reached = 5;   // neighbours that a disk reaches
constexpr double widest = 4.0;       // medians of the radii: wider disks are of isolated points

// At most `most` of n indices, each as probable as any other.
std::vector<std::uint32_t> drawn(std::size_t n, std::size_t most, std::uint64_t seed) {
    Random random(seed);
    std::vector<std::uint32_t> out;
    out.reserve(std::min(n, most));
    // Each with the probability that fills what is left (Knuth's algorithm S).
    for (std::size_t i = 0; i < n && out.size() < most; ++i)
        if (random.below(n - i) < most - out.size()) out.push_back(static_cast<std::uint32_t>(i));
    return out;
}

// The places of a cloud, and of each the points that stand for it: the first one, and the first one that faces away
// from it, if there is one.
struct Places {
    std::vector<Vec3> at;
    std::vector<std::uint32_t> of_point, front, back;  // back: none of places that are seen from one side
    static constexpr std::uint32_t none = SheetSides::none;
    bool two_sided(std::size_t place) const { return back[place] != none; }
};

Places places_of(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, const Progress& progress) {
    DistinctPlaces distinct = distinct_places(points, progress);
    Places out;
    out.at = std::move(distinct.places);
    out.of_point = std::move(distinct.of_point);
    out.front.assign(out.at.size(), Places::none);
    out.back = out.front;
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::uint32_t &front = out.front[out.of_point[i]], &back = out.back[out.of_point[i]];
        if (front == Places::none)
            front = static_cast<std::uint32_t>(i);
        else if (back == Places::none && dot(normals[front], normals[i]) < 0.0)
            back = static_cast<std::uint32_t>(i);
    }
    return out;
}

// Disks of the points that stand for the places looked at.
struct Looked {
    Surfels disks;
    std::vector<std::uint32_t> first;  // per place: its first disk, and at the end the number of disks
};

// The disks reach a near neighbour: of places drawn at random, one in 150 is left uncovered.
Looked disks_of(const Places& places, const std::vector<Vec3>& normals, const std::vector<std::uint32_t>& chosen,
                const PointIndex& index) {
    std::vector<double> reach(chosen.size());
    parallel_blocks(chosen.size(), 1024, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t k = begin; k < end; ++k) {
            index.nearest(places.at[chosen[k]], reached + 1, near);
            reach[k] = near.back().distance;
        }
    });
    std::vector<double> sorted = reach;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    Looked out;
    for (std::size_t k = 0; k < chosen.size(); ++k) {
        const std::uint32_t place = chosen[k];
        out.first.push_back(static_cast<std::uint32_t>(out.disks.positions.size()));
        for (std::uint32_t i : {places.front[place], places.back[place]}) {
            if (i == Places::none) continue;
            out.disks.positions.push_back(places.at[place]);
            out.disks.normals.push_back(normals[i]);
            out.disks.radii.push_back(std::clamp(reach[k], 1e-3 * *middle, widest * *middle));
        }
    }
    out.first.push_back(static_cast<std::uint32_t>(out.disks.positions.size()));
    return out;
}

}  // namespace

Facing facing_of(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, const FacingOptions& options,
                 const Progress& progress) {
    Facing out;
    out.sheet.assign(points.size(), SheetSides::none);
    out.turned.assign(points.size(), 0);
    out.unsure = out.turned;
    if (points.size() < std::max<std::size_t>(options.sheets.smallest, reached + 1)) return out;
    const Places places = places_of(points, normals, progress);
    if (places.at.size() <= reached) return out;
    const std::vector<std::uint32_t> chosen = drawn(places.at.size(), options.most, options.sheets.seed);
    std::vector<Vec3> at;
    for (std::uint32_t place : chosen) at.push_back(places.at[place]);
    const PointIndex index(at, progress);
    const Looked looked = disks_of(places, normals, chosen, index);
    const Surfels& some = looked.disks;
    const SheetSides sides = sheet_sides(some, options.sheets, progress);
    out.sheets = sides.sheets;
    std::vector<bool> against(some.size());
    for (std::size_t i = 0; i < some.size(); ++i) against[i] = sides.turned(i);
    std::vector<char> turned(some.size(), 0);
    for (const std::vector<std::uint32_t>& patch : patches_of(some, sides.graph, against))
        if (patch.size() >= options.sheets.smallest)
            for (std::uint32_t i : patch) turned[i] = 1;

    // Every point has the sheet and the side of the nearest of those looked at that face its way. Where points face
    // both ways, both are right, whatever stands beside them.
    parallel_blocks(
        points.size(), 1024,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near;
            for (std::size_t i = begin; i < end; ++i) {
                index.nearest(points[i], followed, near);
                const bool pair = places.two_sided(places.of_point[i]);
                const auto one_that_faces = [&](double least, bool same_kind) {
                    for (const Neighbor& n : near) {
                        const std::uint32_t begin_disk = looked.first[n.index], end_disk = looked.first[n.index + 1];
                        if (same_kind && (end_disk - begin_disk == 2) != pair) continue;
                        for (std::uint32_t k = begin_disk; k < end_disk; ++k)
                            if (dot(normals[i], some.normals[k]) > least) return k;
                    }
                    return Places::none;
                };
                std::uint32_t leader = one_that_faces(alike, true);  // a pair says nothing about a single point
                if (leader == Places::none) leader = one_that_faces(alike, false);
                if (leader == Places::none) leader = one_that_faces(0.0, false);
                if (leader == Places::none) continue;
                out.sheet[i] = sides.sheet[leader];
                out.turned[i] = turned[leader] && !pair;
                out.unsure[i] = sides.unsure[leader] && !pair;
            }
        },
        progress);
    std::vector<std::size_t> size(out.sheets.size(), 0);
    for (std::uint32_t k : out.sheet)
        if (k != SheetSides::none) ++size[k];
    for (std::size_t k = 0; k < size.size(); ++k) out.sheets[k].size = size[k];
    return out;
}

}  // namespace surflux
