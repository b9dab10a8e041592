#include "surflux/area/disk_overlap.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "surflux/area/close_sheets.h"
#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"
#include "surflux/neighbors/disk_index.h"
#include "surflux/neighbors/piles.h"

namespace surflux {

namespace {

constexpr double deviations = 4.0;  // of heights: 6e-5 of a normal distribution lie beyond
// Between the normals of disks at one place that are one disk, as in area/neighborhood.
constexpr double pile_cosine = 0.999;
constexpr std::size_t block = 256;

// A disk, or several of one object at one place.
struct Disk {
    Vec3 position, normal;
    double radius;
    std::uint32_t object;
    std::vector<std::uint32_t> surfels;  // that it stands for, itself first
};

// Of all disks of objects whose boxes overlap. In Morton order, so that what a search finds is together in memory.
class Disks {
public:
    explicit Disks(const Scene& scene) : scene_(scene) {
        const Surfels& s = scene.surfels;
        const std::vector<std::uint32_t> triangles = triangle_ranges(s);
        std::vector<std::vector<std::uint32_t>> by_object(s.size() > 0 ? scene.object.back() + 1 : 0);
        for (std::uint32_t i = 0; i < s.size(); ++i)
            if (triangles[i] == triangles[i + 1]) by_object[scene.object[i]].push_back(i);
        for (const auto& of_object : by_object) boxes_.push_back(box_of(of_object));
        std::vector<Disk> found;
        for (std::uint32_t o = 0; o < by_object.size(); ++o)
            if (!by_object[o].empty() && meets_another(boxes_[o], o)) add(by_object[o], found);
        if (found.empty()) return;
        std::vector<Vec3> positions;
        std::vector<double> radii;
        for (const Disk& disk : found) positions.push_back(disk.position);
        const std::vector<std::uint32_t> order = morton_order(positions);
        positions.clear();
        for (const std::uint32_t k : order) {
            disks_.push_back(std::move(found[k]));
            positions.push_back(disks_.back().position);
            radii.push_back(disks_.back().radius);
        }
        index_ = std::make_unique<DiskIndex>(positions, radii);
    }

    std::size_t size() const { return disks_.size(); }
    const Disk& operator[](std::size_t k) const { return disks_[k]; }

    // Disks of the same object and surface whose centres lie in reach of disk i, but for i itself.
    void own(std::uint32_t i, std::vector<Neighbor>& near) const {
        near.clear();
        index_->centered_within(disks_[i].position, 2.0 * disks_[i].radius, near);
        keep(near, [&](const Neighbor& found) {
            return found.index != i && disks_[found.index].object == disks_[i].object && face_alike(i, found.index);
        });
    }

    // Disks of other objects that come closer than `reach` to disk i and face its way.
    void others(std::uint32_t i, double reach, std::vector<Neighbor>& near) const {
        near.clear();
        const Disk& disk = disks_[i];
        const Vec3 extent{reach, reach, reach};
        if (!meets_another({disk.position - extent, disk.position + extent}, disk.object)) return;
        index_->reaching(disk.position, reach, near);
        keep(near, [&](const Neighbor& found) {
            return disks_[found.index].object != disk.object && face_alike(i, found.index);
        });
    }

private:
    template <class Kept>
    static void keep(std::vector<Neighbor>& near, const Kept& kept) {
        near.erase(std::remove_if(near.begin(), near.end(), [&](const Neighbor& n) { return !kept(n); }), near.end());
    }
    bool face_alike(std::uint32_t i, std::uint32_t k) const {
        return dot(disks_[i].normal, disks_[k].normal) >= alike_normals;
    }

    Box box_of(const std::vector<std::uint32_t>& disks) const {
        Box box;
        for (const std::uint32_t i : disks)
            for (int axis = 0; axis < 3; ++axis) {
                const double at = scene_.surfels.positions[i][axis], radius = scene_.surfels.radii[i];
                const bool first = i == disks.front();
                box.low[axis] = first ? at - radius : std::min(box.low[axis], at - radius);
                box.high[axis] = first ? at + radius : std::max(box.high[axis], at + radius);
            }
        if (disks.empty()) box.low = {1, 1, 1}, box.high = {-1, -1, -1};
        return box;
    }
    bool meets_another(const Box& box, std::uint32_t object) const {
        for (std::uint32_t o = 0; o < boxes_.size(); ++o) {
            const Box& other = boxes_[o];
            bool meets = o != object && other.low.x <= other.high.x;
            for (int axis = 0; axis < 3 && meets; ++axis)
                meets = box.low[axis] <= other.high[axis] && other.low[axis] <= box.high[axis];
            if (meets) return true;
        }
        return false;
    }

    void add(const std::vector<std::uint32_t>& surfels, std::vector<Disk>& out) const {
        const Surfels& s = scene_.surfels;
        std::vector<Vec3> positions, normals;
        std::vector<double> radii;
        for (const std::uint32_t i : surfels) {
            positions.push_back(s.positions[i]);
            normals.push_back(s.normals[i]);
            radii.push_back(s.radii[i]);
        }
        std::vector<char> is_piled(surfels.size(), 0);
        const auto add_one = [&](std::uint32_t first) {
            const std::uint32_t i = surfels[first];
            out.push_back({s.positions[i], s.normals[i], s.radii[i], scene_.object[i], {}});
        };
        for (const auto& pile : find_piles(positions, normals, radii, pile_cosine)) {
            add_one(pile.front());
            for (const std::uint32_t member : pile) {
                is_piled[member] = 1;
                out.back().surfels.push_back(surfels[member]);
            }
        }
        for (std::uint32_t k = 0; k < surfels.size(); ++k) {
            if (is_piled[k]) continue;
            add_one(k);
            out.back().surfels.push_back(surfels[k]);
        }
    }

    const Scene& scene_;
    std::vector<Box> boxes_;  // of the disks of each object; low above high where there are none
    std::vector<Disk> disks_;
    std::unique_ptr<DiskIndex> index_;
};

// Of the disks around one, over its plane.
struct Heights {
    double mean_square = -1.0, variance = 0.0;
};

Heights heights_of(const Disks& disks, std::uint32_t i, std::vector<Neighbor>& near) {
    disks.own(i, near);
    if (near.empty()) return {0.0, 0.0};
    double sum = 0.0, squared = 0.0;
    for (const Neighbor& found : near) {
        const double height = dot(disks[i].normal, disks[found.index].position - disks[i].position);
        sum += height;
        squared += height * height;
    }
    const auto count = static_cast<double>(near.size());
    return {squared / count, std::max(0.0, squared / count - sum * sum / (count * count))};
}

// Four times the RMS height in the surroundings, in which that of one disk has no larger say than others. Twice the
// variance over a single one's plane has the same mean, and tells where that plane is tilted.
double spread_of(const Disks& disks, const std::vector<Heights>& heights, double contact, std::uint32_t i,
                 std::vector<Neighbor>& near) {
    disks.own(i, near);
    double sum = heights[i].mean_square;
    int count = 1;
    for (const Neighbor& found : near)
        if (heights[found.index].mean_square >= 0.0) sum += heights[found.index].mean_square, ++count;
    return contact + deviations * std::sqrt(std::max(sum / count, 2.0 * heights[i].variance));
}

// Of a disk and what another object has around it.
struct Meeting {
    std::uint32_t disk, object;
    bool joined;
    double height;  // where that is a layer closely over or under it; else negative
};

// Does what another object has around disk i stand for the same surface? Most of it decides.
void add_meetings(const Disks& disks, const std::vector<double>& spread, std::uint32_t i, std::vector<Neighbor>& near,
                  std::vector<Meeting>& out) {
    struct Seen {
        std::size_t all = 0, within = 0;
        double height = 0.0, radius = 0.0;
    };
    std::map<std::uint32_t, Seen> by_object;
    disks.others(i, disks[i].radius, near);
    for (const Neighbor& found : near) {
        const Disk& k = disks[found.index];
        const double height = std::abs(dot(k.normal, disks[i].position - k.position));
        Seen& seen = by_object[k.object];
        ++seen.all;
        seen.within += height <= std::max(spread[i], spread[found.index]);
        seen.height += height;
        seen.radius += k.radius;
    }
    for (const auto& [object, seen] : by_object) {
        const bool joined = 2 * seen.within >= seen.all, layer = !joined && seen.height <= close_disk * seen.radius;
        if (joined || layer)
            out.push_back({i, object, joined, layer ? seen.height / static_cast<double>(seen.all) : -1.0});
    }
}

void count_meetings(const Disks& disks, const std::vector<std::vector<Meeting>>& meetings, DiskOverlaps& out) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, Overlap> overlaps;
    for (const auto& some : meetings)
        for (const Meeting& at : some) {
            const Disk& disk = disks[at.disk];
            const std::size_t count = disk.surfels.size();
            const std::pair<std::uint32_t, std::uint32_t> pair = std::minmax(at.object, disk.object);
            Overlap& overlap = overlaps[pair];
            overlap.one = pair.first, overlap.other = pair.second;
            if (at.joined) {
                overlap.joined += count;
                for (const std::uint32_t i : disk.surfels) out.is_joined[i] = 1;
            } else {
                overlap.layered += count;
                overlap.height += static_cast<double>(count) * at.height;
            }
        }
    for (auto& [pair, overlap] : overlaps) {
        if (overlap.layered > 0) overlap.height /= static_cast<double>(overlap.layered);
        out.overlaps.push_back(overlap);
    }
}

// Calls body(index, near) for all of them.
template <class Body>
void for_each(const std::vector<std::uint32_t>& indices, const Progress& progress, const Body& body) {
    parallel_blocks(
        indices.size(), block,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> near;
            for (std::size_t k = begin; k < end; ++k) body(k, indices[k], near);
        },
        progress);
}

}  // namespace

DiskOverlaps find_disk_overlaps(const Scene& scene, const Extent& extent, const Progress& progress) {
    const Disks disks(scene);
    DiskOverlaps out;
    std::vector<char> meets(disks.size(), 0);
    std::vector<std::uint32_t> all(disks.size());
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    std::vector<Heights> heights(disks.size());
    for_each(all, progress, [&](std::size_t, std::uint32_t i, std::vector<Neighbor>& near) {
        disks.others(i, disks[i].radius, near);
        meets[i] = !near.empty();
        if (meets[i]) heights[i] = heights_of(disks, i, near);
    });
    all.erase(std::remove_if(all.begin(), all.end(), [&](std::uint32_t i) { return !meets[i]; }), all.end());
    if (all.empty()) return out;
    std::vector<double> spread(disks.size(), 0.0);
    for_each(all, progress, [&](std::size_t, std::uint32_t i, std::vector<Neighbor>& near) {
        // Rays take surfaces so close to the surfel for its own.
        const double contact = 2.0 * extent.contact_of(disks[i].surfels.front());
        spread[i] = spread_of(disks, heights, contact, i, near);
    });
    std::vector<std::vector<Meeting>> meetings((all.size() + block - 1) / block);
    for_each(all, progress, [&](std::size_t k, std::uint32_t i, std::vector<Neighbor>& near) {
        add_meetings(disks, spread, i, near, meetings[k / block]);
    });
    out.is_joined.assign(scene.surfels.size(), 0);
    count_meetings(disks, meetings, out);
    out.spread.assign(scene.surfels.size(), 0.0);
    for (const std::uint32_t d : all)
        for (const std::uint32_t i : disks[d].surfels)
            if (out.is_joined[i]) out.spread[i] = spread[d];
    return out;
}

}  // namespace surflux
