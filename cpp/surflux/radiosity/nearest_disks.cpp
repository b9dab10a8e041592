#include "surflux/radiosity/nearest_disks.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "surflux/core/parallel.h"
#include "surflux/neighbors/point_index.h"

namespace surflux {

namespace {

// Of what is drawn by a place: its bits, mixed (Steele, Lea and Flood 2014).
std::uint64_t number_of(const Vec3& at) {
    std::uint64_t mixed = 0x9e3779b97f4a7c15u;
    for (int axis = 0; axis < 3; ++axis) {
        std::uint64_t bits;
        std::memcpy(&bits, &at[axis], sizeof bits);
        mixed = (mixed ^ bits) * 0xbf58476d1ce4e5b9u;
        mixed ^= mixed >> 29;
    }
    return mixed;
}

}  // namespace

NearestDisks::NearestDisks(const Scene& scene, const Progress& progress, const RefinementTuning& tuning)
    : scene_(scene), each_(whole_number(tuning.disks_beside)), own_cell_(tuning.own_cell) {
    const Surfels& s = scene.surfels;
    const std::vector<std::uint32_t> triangles = triangle_ranges(s);
    if (s.triangles.size() > 0 && std::adjacent_find(triangles.begin(), triangles.end()) == triangles.end()) return;
    const PointIndex index(s.positions, progress);
    const std::size_t beside = each_, looked_at = whole_number(tuning.disks_looked_at);
    beside_.resize(s.size() * beside);
    const auto find = [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t k = begin; k < end; ++k) {
            const auto i = static_cast<std::uint32_t>(k);
            std::uint32_t* out = &beside_[k * beside];
            std::fill_n(out, beside, i);
            if (triangles[i] != triangles[i + 1]) continue;
            index.nearest(s.positions[i], looked_at, near);
            std::size_t count = 0;
            for (const Neighbor& other : near)
                if (other.index != i && count < beside && scene.object[other.index] == scene.object[i] &&
                    triangles[other.index] == triangles[other.index + 1] &&
                    dot(s.normals[other.index], s.normals[i]) > 0.5)
                    out[count++] = other.index;
        }
    };
    parallel_blocks(s.size(), 256, find, progress);
}

// Copies of a disk are met in turn.
std::uint32_t NearestDisks::one_of_its_place(std::uint32_t surfel, const Vec3& at) const {
    const std::size_t beside = each_;
    const std::uint32_t* others = &beside_[surfel * beside];
    const Vec3& here = scene_.surfels.positions[surfel];
    std::size_t copies = 0;  // the nearest, so that they come first
    while (copies < beside && others[copies] != surfel && scene_.surfels.positions[others[copies]] == here) ++copies;
    if (copies == 0) return surfel;
    const std::size_t one = number_of(at) % (copies + 1);
    return one == copies ? surfel : others[one];
}

std::uint32_t NearestDisks::owner(std::uint32_t surfel, const Vec3& at) const {
    if (beside_.empty()) return surfel;
    const Surfels& s = scene_.surfels;
    double least = length_squared(s.positions[surfel] - at);
    // Well within its own cell it has no rival.
    if (!(least > own_cell_ * s.areas[surfel])) return one_of_its_place(surfel, at);
    const std::size_t beside = each_;
    // Nearer and nearer: a disk that reaches far has none of those around the place beside it.
    for (std::uint32_t from = std::numeric_limits<std::uint32_t>::max(); from != surfel;) {
        from = surfel;
        const std::uint32_t* others = &beside_[from * beside];
        for (std::size_t k = 0; k < beside; ++k) {
            const double squared = length_squared(s.positions[others[k]] - at);
            if (squared < least) least = squared, surfel = others[k];
        }
    }
    return one_of_its_place(surfel, at);
}

}  // namespace surflux
