#include <algorithm>
#include <cmath>
#include <numeric>

#include "surflux/core/parallel.h"
#include "surflux/neighbors/distinct_places.h"
#include "surflux/neighbors/point_index.h"
#include "surflux/trace/tracer.h"
#include "surflux/trace/tracer_impl.h"

namespace surflux {

namespace {

// Places looked at around a disk, its own among them: the disks that overlap it, 18 or so, where scans of a surface
// lie over each other without coinciding, too.
constexpr std::size_t surrounding = 33;

// A ray that leaves a closed cloud between disks that miss each other does so no farther than this from the centre of
// one of them, in its radii: they cover the surface with a tenth to spare (neighbors/radii.h), but are tilted where it
// bends.
constexpr float patch_reach = 1.25f;

// How often the disks around the place where a ray seems to come out are asked whether it does. More than twice changes
// next to nothing on spheres, ellipsoids, rounded boxes and statues.
constexpr int steps = 2;

// Disks of one object, or of all, that rays meet; one for each place.
struct Places {
    std::vector<std::uint32_t> surfel;
    std::unique_ptr<PointIndex> index;
};

Places places_of(const Surfels& s, const std::vector<std::uint32_t>& surfels, const Progress& progress) {
    std::vector<Vec3> positions;
    positions.reserve(surfels.size());
    for (const std::uint32_t i : surfels) positions.push_back(s.positions[i]);
    const DistinctPlaces distinct = distinct_places(positions, progress);
    Places out;
    for (std::size_t k = 0; k < surfels.size(); ++k)
        if (distinct.of_point[k] == out.surfel.size()) out.surfel.push_back(surfels[k]);
    out.index = std::make_unique<PointIndex>(distinct.places, progress);
    return out;
}

}  // namespace

// Each disk among those of its own object, so that copies of that do not stand in for what is around; scans that stand
// for one surface together (Scene::spread) also among all.
void Tracer::Impl::find_lower(const Scene& of, const Progress& progress) {
    const Surfels& s = of.surfels;
    lower_begin.assign(s.size() + 1, 0);
    std::vector<std::uint32_t> surfels;
    for (std::uint32_t i = 0; i < disks.size(); ++i)
        if (disks[i].is_disk()) surfels.push_back(i);
    if (surfels.empty()) return;
    std::vector<std::vector<std::uint32_t>> of_object(of.object.back() + 1);
    for (const std::uint32_t i : surfels) of_object[of.object[i]].push_back(i);
    std::vector<Places> own(of_object.size());
    const Progress asked = standing_at(0, surfels.size(), progress);
    for (std::size_t o = 0; o < own.size(); ++o)
        if (!of_object[o].empty()) own[o] = places_of(s, of_object[o], asked);
    Places all;
    if (!of.spread.empty()) all = places_of(s, surfels, asked);

    constexpr std::size_t grain = 256;
    std::vector<std::vector<std::uint32_t>> found((surfels.size() + grain - 1) / grain);
    const auto find = [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t k = begin; k < end; ++k) {
            const std::uint32_t i = surfels[k];
            const auto look = [&](const Places& places, bool others) {
                places.index->nearest(s.positions[i], surrounding, near);
                for (const Neighbor& n : near) {
                    const std::uint32_t j = places.surfel[n.index];
                    if (j == i || (others && of.object[j] == of.object[i])) continue;
                    if (!rises_over(s, i, j, n.distance)) continue;
                    found[begin / grain].push_back(j);
                    ++lower_begin[i + 1];
                }
            };
            look(own[of.object[i]], false);
            if (disks[i].spread > 0.0f) look(all, true);
        }
    };
    parallel_blocks(surfels.size(), grain, find, progress);
    std::partial_sum(lower_begin.begin(), lower_begin.end(), lower_begin.begin());
    lower.reserve(lower_begin.back());
    for (const auto& some : found) lower.insert(lower.end(), some.begin(), some.end());
}

// Does the surface of disk j go on below the rim of disk i?
bool Tracer::Impl::rises_over(const Surfels& s, std::uint32_t i, std::uint32_t j, double distance) const {
    if (distance >= s.radii[i] + s.radii[j]) return false;
    const Disk &p = disks[i], &q = disks[j];
    const double height = dot(s.positions[i] - s.positions[j], s.normals[j]) / unit,
                 rise = length(cross(s.normals[i], s.normals[j])) * s.radii[i] / unit,
                 touching = 2.0 * static_cast<double>(std::max(p.contact, q.contact));
    // A layer over another has its centres over it, too.
    return height <= touching && height + rise > touching &&
           is_one_surface(p, q, dot3(p.normal, q.normal), static_cast<float>(std::abs(height)));
}

// Tangent planes bound a convex body: a ray has been in it only if it was below all of them at once. So it is asked of
// the disk that it crosses and of those that this rises over, which form a patch of the surface; where the ray seems to
// have come out of that, of the disks around that place, too. A ray from inside of a convex cloud was below all planes
// where it began, whichever are asked; one from outside was never.
bool Tracer::Impl::passes_under_rim(std::uint32_t from, const Crossing& hit) const {
    const Disk& q = disks[hit.surfel];
    // How far back along the ray it is below all planes: nowhere, if `first` is beyond `last`.
    float first = 0.0f, last = hit.distance();
    const auto stays_above = [&](const LowerDisks& around) {
        for (const std::uint32_t k : around) {
            const Disk& below = disks[k];
            float at[3];
            for (int axis = 0; axis < 3; ++axis)
                at[axis] = hit.from(below, axis) + hit.distance() * hit.direction[axis];
            const float height = dot3(at, below.normal) + 2.0f * std::max(q.contact, below.contact),
                        rise = dot3(hit.direction, below.normal);
            if (rise > 0.0f) first = std::max(first, height / rise);
            if (rise < 0.0f) last = std::min(last, height / rise);
            if (first > last || (rise <= 0.0f && height > 0.0f)) return true;
        }
        return false;
    };
    // Squared distance from where the ray came out, in radii.
    const auto beside = [&](std::uint32_t k) {
        float squared = 0.0f;
        for (int axis = 0; axis < 3; ++axis) {
            const float d = hit.from(disks[k], axis) + (hit.distance() - first) * hit.direction[axis];
            squared += d * d;
        }
        return squared / (disks[k].radius * disks[k].radius);
    };

    const LowerDisks patch = lower_of(hit.surfel);
    if (stays_above(patch)) return true;
    // What leaves the front of the patch has not been inside either.
    if (from != no_surfel && dot3(hit.direction, disks[from].normal) > 0.0f && rise_over(patch, from)) return true;
    std::uint32_t nearest = hit.surfel;
    float least = beside(nearest);
    const auto look = [&](const LowerDisks& around) {
        for (const std::uint32_t k : around)
            if (const float squared = beside(k); squared < least) least = squared, nearest = k;
    };
    look(patch);
    std::uint32_t asked = hit.surfel;
    for (int step = 0; step < steps && nearest != asked; ++step) {
        asked = nearest;
        if (stays_above(lower_of(asked))) return true;
        least = beside(asked);
        look(lower_of(asked));
    }
    return least > patch_reach * patch_reach;
}

// Does one of those disks rise over surfel i?
bool Tracer::Impl::rise_over(const LowerDisks& around, std::uint32_t i) const {
    return std::any_of(around.begin(), around.end(), [&](std::uint32_t k) {
        const LowerDisks below = lower_of(k);
        return std::find(below.begin(), below.end(), i) != below.end();
    });
}

}  // namespace surflux
