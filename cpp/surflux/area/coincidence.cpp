#include "surflux/area/coincidence.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/neighbors/disk_index.h"
#include "surflux/scene/extent.h"

namespace surflux {

namespace {

constexpr double alike = 0.5;       // cosine between normals of one surface
constexpr double flat = 0.999;      // of patches in one plane; where others meet, only a strip is as close
constexpr double deviations = 4.0;  // of heights: 6e-5 of a normal distribution lie beyond
constexpr double closely = 0.25;    // of a disk's radius: a layer that near may be a scan that is misplaced
constexpr double least_share = 1e-9;

using Polygon = std::vector<Vec3>;

// Of a convex polygon, the part with dot(normal, p) <= limit, and the rest (Sutherland and Hodgman 1974).
void split(const Polygon& polygon, const Vec3& normal, double limit, Polygon& inside, Polygon& outside) {
    inside.clear(), outside.clear();
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vec3 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
        const double at_a = dot(normal, a) - limit, at_b = dot(normal, b) - limit;
        if (at_a <= 0.0) inside.push_back(a);
        if (at_a >= 0.0) outside.push_back(a);
        if ((at_a < 0.0 && at_b > 0.0) || (at_a > 0.0 && at_b < 0.0)) {
            inside.push_back(a + at_a / (at_a - at_b) * (b - a));
            outside.push_back(inside.back());
        }
    }
}

double area_of(const Polygon& polygon) {
    Vec3 sum;
    for (std::size_t k = 2; k < polygon.size(); ++k) sum += cross(polygon[k - 1] - polygon[0], polygon[k] - polygon[0]);
    return 0.5 * length(sum);
}

double area_of(const std::vector<Polygon>& pieces) {
    double sum = 0.0;
    for (const Polygon& piece : pieces) sum += area_of(piece);
    return sum;
}

// What of the pieces, given from `origin`, the triangle does not cover within `contact`.
std::vector<Polygon> without(const std::vector<Polygon>& pieces, const Triangle& t, const Vec3& origin,
                             double contact) {
    const Vec3 corners[3] = {t.a - origin, t.b - origin, t.c - origin};
    const Vec3 normal = normalized(cross_of(t));
    std::vector<Polygon> out, rest;
    Polygon in, off;
    for (const Polygon& all : pieces) {
        Polygon piece = all;
        rest.clear();
        const auto cut = [&](const Vec3& n, double limit) {
            if (piece.size() < 3) return;
            split(piece, n, limit, in, off);
            if (off.size() >= 3) rest.push_back(off);
            piece.swap(in);
        };
        for (int k = 0; k < 3; ++k) {
            const Vec3 outwards = normalized(cross(corners[(k + 1) % 3] - corners[k], normal));
            cut(outwards, dot(outwards, corners[k]));
        }
        const double height = dot(normal, corners[0]);
        cut(normal, height + contact);
        cut(-normal, contact - height);
        // A piece that the triangle does not reach stays whole.
        if (piece.size() < 3 || !(area_of(piece) > 0.0)) rest.assign(1, all);
        out.insert(out.end(), rest.begin(), rest.end());
    }
    return out;
}

struct Heights {
    double mean_square = -1.0, variance = 0.0;
};

struct Finder {
    const Scene& scene;
    const Surfels& s;
    std::vector<std::uint32_t> triangles;
    Extent extent;
    DiskIndex index;
    Coincidence out;

    explicit Finder(const Scene& of)
        : scene(of), s(of.surfels), triangles(triangle_ranges(s)), extent(s), index(s.positions, s.radii) {}

    bool is_patch(std::uint32_t i) const { return triangles[i] != triangles[i + 1]; }
    // Rays take surfaces so close to surfel i for its own.
    double contact_of(std::uint32_t i) const { return 2.0 * extent.contact_of(i); }

    void patch(std::uint32_t i, std::vector<Neighbor>& near, std::vector<Cover>& covers) {
        const double contact = contact_of(i);
        near.clear();
        index.reaching(s.positions[i], s.radii[i] + contact, near);
        std::vector<std::uint32_t> above;
        for (const Neighbor& found : near) {
            const std::uint32_t k = found.index;
            if (k <= i || !is_patch(k) || dot(s.normals[i], s.normals[k]) < flat) continue;
            // How far a corner of either may rise over the other's plane by their tilt.
            const double rise = length(cross(s.normals[i], s.normals[k])) * (s.radii[i] + s.radii[k]);
            if (std::abs(dot(s.normals[k], s.positions[i] - s.positions[k])) <= contact + rise) above.push_back(k);
        }
        if (above.empty()) return;
        std::sort(above.begin(), above.end());
        std::vector<Polygon> pieces;
        for (std::uint32_t t = triangles[i]; t < triangles[i + 1]; ++t) {
            const Triangle& own = s.triangles[t];
            pieces.push_back({own.a - s.positions[i], own.b - s.positions[i], own.c - s.positions[i]});
        }
        const std::vector<Polygon> whole = pieces;
        const double all = area_of(whole);
        bool covered = false;
        for (std::uint32_t k : above) {
            const auto take = [&](std::vector<Polygon> from) {
                for (std::uint32_t t = triangles[k]; t < triangles[k + 1]; ++t)
                    if (!from.empty()) from = without(from, s.triangles[t], s.positions[i], contact);
                return from;
            };
            // Edges that two patches share may overlap by as much as places are rounded.
            if (all - area_of(take(whole)) <= contact * std::min(s.radii[i], s.radii[k])) continue;
            covers.push_back({i, k});
            covered = true;
            pieces = take(pieces);
        }
        if (covered) out.uncovered[i] = std::min(1.0, area_of(pieces) / all);
    }

    // Appends the disks of the same object and surface whose centres lie in reach of disk i, but for i itself.
    void own(std::uint32_t i, std::vector<Neighbor>& near) const {
        near.clear();
        index.centered_within(s.positions[i], 2.0 * s.radii[i], near);
        const auto strange = [&](const Neighbor& found) {
            const std::uint32_t k = found.index;
            return k == i || scene.object[k] != scene.object[i] || is_patch(k) ||
                   dot(s.normals[i], s.normals[k]) < alike;
        };
        near.erase(std::remove_if(near.begin(), near.end(), strange), near.end());
    }

    // Of their heights over the plane of disk i.
    Heights heights(std::uint32_t i, std::vector<Neighbor>& near) const {
        own(i, near);
        if (near.empty()) return {0.0, 0.0};
        double sum = 0.0, squared = 0.0;
        for (const Neighbor& found : near) {
            const double height = dot(s.normals[i], s.positions[found.index] - s.positions[i]);
            sum += height;
            squared += height * height;
        }
        const auto count = static_cast<double>(near.size());
        return {squared / count, std::max(0.0, squared / count - sum * sum / (count * count))};
    }

    // Disks of other objects that reach disk i and face its way.
    void others(std::uint32_t i, std::vector<Neighbor>& near) const {
        near.clear();
        index.reaching(s.positions[i], s.radii[i], near);
        const auto strange = [&](const Neighbor& found) {
            const std::uint32_t k = found.index;
            return scene.object[k] == scene.object[i] || is_patch(k) || dot(s.normals[i], s.normals[k]) < alike;
        };
        near.erase(std::remove_if(near.begin(), near.end(), strange), near.end());
    }
};

// Of a disk and what another object has around it.
struct Meeting {
    std::uint32_t surfel, object;
    bool joined;
    double height;  // where that is a layer closely over or under it; else negative
};

// The spread of each of them: four times the RMS height in its surroundings, in which that of one disk has no larger
// say than others. Twice the variance over a single one's plane has the same mean, and tells where that plane is
// tilted.
void find_spreads(const Finder& finder, const std::vector<std::uint32_t>& all, std::vector<double>& spread) {
    std::vector<Heights> heights(spread.size());
    parallel_blocks(all.size(), 64, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t k = begin; k < end; ++k) heights[all[k]] = finder.heights(all[k], near);
    });
    parallel_blocks(all.size(), 64, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t k = begin; k < end; ++k) {
            const std::uint32_t i = all[k];
            finder.own(i, near);
            double sum = heights[i].mean_square;
            int count = 1;
            for (const Neighbor& found : near)
                if (heights[found.index].mean_square >= 0.0) sum += heights[found.index].mean_square, ++count;
            spread[i] = finder.contact_of(i) + deviations * std::sqrt(std::max(sum / count, 2.0 * heights[i].variance));
        }
    });
}

// Does what another object has around disk i stand for the same surface? Most of it decides.
void add_meetings(const Finder& finder, std::uint32_t i, std::vector<Neighbor>& near, std::vector<Meeting>& out) {
    const Surfels& s = finder.s;
    const std::vector<double>& spread = finder.out.spread;
    struct Seen {
        std::size_t all = 0, within = 0;
        double height = 0.0, radius = 0.0;
    };
    std::map<std::uint32_t, Seen> by_object;
    finder.others(i, near);
    for (const Neighbor& found : near) {
        const std::uint32_t k = found.index;
        const double height = std::abs(dot(s.normals[k], s.positions[i] - s.positions[k]));
        Seen& seen = by_object[finder.scene.object[k]];
        ++seen.all;
        seen.within += height <= std::max(spread[i], spread[k]);
        seen.height += height;
        seen.radius += s.radii[k];
    }
    for (const auto& [object, seen] : by_object) {
        const bool joined = 2 * seen.within >= seen.all, layer = !joined && seen.height <= closely * seen.radius;
        if (joined || layer)
            out.push_back({i, object, joined, layer ? seen.height / static_cast<double>(seen.all) : -1.0});
    }
}

void count_meetings(const Scene& scene, const std::vector<Meeting>& meetings, Coincidence& out) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, Overlap> overlaps;
    for (const Meeting& at : meetings) {
        const std::pair<std::uint32_t, std::uint32_t> pair = std::minmax(at.object, scene.object[at.surfel]);
        Overlap& overlap = overlaps[pair];
        overlap.one = pair.first, overlap.other = pair.second;
        overlap.joined += at.joined;
        if (at.joined) {
            out.is_joined[at.surfel] = 1;
        } else {
            ++overlap.layered;
            overlap.height += at.height;
        }
    }
    for (auto& [pair, overlap] : overlaps) {
        if (overlap.layered > 0) overlap.height /= static_cast<double>(overlap.layered);
        out.overlaps.push_back(overlap);
    }
}

// What the blocks of a parallel loop found, in their order.
template <class T>
std::vector<T> in_order(const std::vector<std::vector<T>>& blocks) {
    std::vector<T> out;
    for (const auto& some : blocks) out.insert(out.end(), some.begin(), some.end());
    return out;
}

// Of how many objects the disks cover a place, each as far as its ends.
class Layers {
public:
    explicit Layers(const Scene& scene)
        : scene_(scene),
          s_(scene.surfels),
          triangles_(triangle_ranges(s_)),
          ends_(end_ranges(s_)),
          index_(s_.positions, s_.radii) {}

    // Mean of 1 / layers over the disk of the area of surfel i, as far as its ends: at its centre and at six points
    // around, each for a seventh of it.
    double share_of(std::uint32_t i) const {
        const Frame frame = frame_around(s_.normals[i]);
        const double reach = std::sqrt(s_.areas[i] / pi) * std::sqrt(4.0 / 7.0);
        thread_local std::vector<Neighbor> near;
        near.clear();
        index_.reaching(s_.positions[i], reach, near);
        const auto strange = [&](const Neighbor& found) {
            const std::uint32_t k = found.index;
            return scene_.object[k] == scene_.object[i] || triangles_[k] != triangles_[k + 1] ||
                   dot(s_.normals[i], s_.normals[k]) < alike || !same_surface(scene_, i, k);
        };
        near.erase(std::remove_if(near.begin(), near.end(), strange), near.end());
        double sum = share_at(s_.positions[i], near);
        int count = 1;
        for (int k = 0; k < 6; ++k) {
            const double angle = pi / 3.0 * k;
            const Vec3 place = s_.positions[i] + reach * (std::cos(angle) * frame.u + std::sin(angle) * frame.v);
            if (is_beyond_end(i, place)) continue;
            sum += share_at(place, near);
            ++count;
        }
        return sum / count;
    }

private:
    double share_at(const Vec3& place, const std::vector<Neighbor>& near) const {
        thread_local std::vector<std::uint32_t> objects;
        objects.clear();
        for (const Neighbor& found : near) {
            const std::uint32_t k = found.index;
            if (length_squared(place - s_.positions[k]) < s_.radii[k] * s_.radii[k] && !is_beyond_end(k, place))
                objects.push_back(scene_.object[k]);
        }
        std::sort(objects.begin(), objects.end());
        return 1.0 / static_cast<double>(1 + (std::unique(objects.begin(), objects.end()) - objects.begin()));
    }

    bool is_beyond_end(std::uint32_t k, const Vec3& place) const {
        for (std::uint32_t e = ends_[k]; e < ends_[k + 1]; ++e)
            if (dot(s_.ends[e].normal, place - s_.positions[k]) > s_.ends[e].limit) return true;
        return false;
    }

    const Scene& scene_;
    const Surfels& s_;
    std::vector<std::uint32_t> triangles_, ends_;
    DiskIndex index_;
};

}  // namespace

Coincidence find_coincidence(const Scene& scene, const Progress& progress) {
    const std::size_t n = scene.surfels.size();
    Finder finder(scene);
    Coincidence& out = finder.out;
    out.uncovered.assign(n, 1.0);
    constexpr std::size_t block = 256;
    const std::size_t blocks = (n + block - 1) / block;
    std::vector<std::vector<Cover>> covers(blocks);
    std::vector<std::vector<std::uint32_t>> near_others(blocks);
    const bool one_object = scene.object.empty() || scene.object.front() == scene.object.back();
    parallel_blocks(
        n, block,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near;
            for (std::size_t k = begin; k < end; ++k) {
                const auto i = static_cast<std::uint32_t>(k);
                if (finder.is_patch(i)) {
                    finder.patch(i, near, covers[begin / block]);
                    continue;
                }
                if (one_object) continue;
                finder.others(i, near);
                if (near.empty()) continue;
                near_others[begin / block].push_back(i);
            }
        },
        progress);
    out.covers = in_order(covers);
    const std::vector<std::uint32_t> all = in_order(near_others);
    if (all.empty()) return std::move(out);
    out.spread.assign(n, 0.0);
    out.is_joined.assign(n, 0);
    find_spreads(finder, all, out.spread);
    std::vector<std::vector<Meeting>> meetings((all.size() + block - 1) / block);
    parallel_blocks(all.size(), block, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t k = begin; k < end; ++k) add_meetings(finder, all[k], near, meetings[begin / block]);
    });
    count_meetings(scene, in_order(meetings), out);
    for (std::size_t i = 0; i < n; ++i)
        if (!out.is_joined[i]) out.spread[i] = 0.0;
    return std::move(out);
}

void count_once(Scene& scene, const Coincidence& found) {
    scene.covers = found.covers;
    scene.spread = found.spread;
    Surfels& s = scene.surfels;
    if (s.areas.empty()) return;
    std::vector<double> share = found.uncovered;
    if (std::find(found.is_joined.begin(), found.is_joined.end(), 1) != found.is_joined.end()) {
        const Layers layers(scene);
        parallel_for(s.size(), 64, [&](std::size_t i) {
            if (found.is_joined[i]) share[i] = layers.share_of(static_cast<std::uint32_t>(i));
        });
    }
    for (std::size_t i = 0; i < s.size(); ++i)
        if (share[i] < 1.0) s.areas[i] *= std::max(share[i], least_share);
}

}  // namespace surflux
