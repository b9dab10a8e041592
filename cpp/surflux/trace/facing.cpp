#include "surflux/trace/facing.h"

#include <algorithm>

#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

constexpr std::size_t followed = 6;  // points looked at that one beside them follows
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

// Disks that reach a near neighbour: of points drawn at random, one in 150 is left uncovered.
Surfels disks_of(const std::vector<Vec3>& points, const std::vector<Vec3>& normals,
                 const std::vector<std::uint32_t>& chosen, const PointIndex& index) {
    Surfels out;
    for (std::uint32_t i : chosen) {
        out.positions.push_back(points[i]);
        out.normals.push_back(normals[i]);
    }
    out.radii.resize(chosen.size());
    parallel_blocks(chosen.size(), 1024, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t k = begin; k < end; ++k) {
            index.nearest(out.positions[k], reached + 1, near);
            out.radii[k] = near.back().distance;
        }
    });
    std::vector<double> radii = out.radii;
    const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
    std::nth_element(radii.begin(), middle, radii.end());
    for (double& radius : out.radii) radius = std::clamp(radius, 1e-3 * *middle, widest * *middle);
    return out;
}

}  // namespace

Facing facing_of(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, const FacingOptions& options,
                 const Progress& progress) {
    Facing out;
    out.sheet.assign(points.size(), SheetSides::none);
    out.turned.assign(points.size(), 0);
    if (points.size() < std::max<std::size_t>(options.sheets.smallest, reached + 1)) return out;
    const std::vector<std::uint32_t> chosen = drawn(points.size(), options.most, options.sheets.seed);
    std::vector<Vec3> places;
    for (std::uint32_t i : chosen) places.push_back(points[i]);
    const PointIndex index(places, progress);
    const Surfels some = disks_of(points, normals, chosen, index);
    const SheetSides sides = sheet_sides(some, options.sheets, progress);
    out.sheets = sides.sheets;
    std::vector<bool> against(some.size());
    for (std::size_t i = 0; i < some.size(); ++i) against[i] = sides.turned(i);
    std::vector<char> turned(some.size(), 0);
    for (const std::vector<std::uint32_t>& patch : patches_of(some, sides.graph, against))
        if (patch.size() >= options.sheets.smallest)
            for (std::uint32_t i : patch) turned[i] = 1;

    // Every point has the sheet and the side of the nearest of those looked at that face its way.
    parallel_blocks(
        points.size(), 1024,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near;
            for (std::size_t i = begin; i < end; ++i) {
                index.nearest(points[i], followed, near);
                const auto one_that_faces = [&](double least) {
                    return std::find_if(near.begin(), near.end(), [&](const Neighbor& n) {
                        return dot(normals[i], some.normals[n.index]) > least;
                    });
                };
                auto leader = one_that_faces(alike);
                if (leader == near.end()) leader = one_that_faces(0.0);
                if (leader == near.end()) continue;
                out.sheet[i] = sides.sheet[leader->index];
                out.turned[i] = turned[leader->index];
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
