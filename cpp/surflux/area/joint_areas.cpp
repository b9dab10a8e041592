#include "surflux/area/joint_areas.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "surflux/area/close_sheets.h"
#include "surflux/area/disk_integrator.h"
#include "surflux/area/neighborhood.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/core/thread_scratch.h"
#include "surflux/neighbors/disk_index.h"
#include "surflux/neighbors/disk_kernel.h"

namespace surflux {

namespace {

constexpr std::size_t block = 16;

struct End {
    Vec3 normal;
    double limit;
    bool is_border;
};

// A joined disk, or several of one object at one place.
struct Disk {
    std::uint32_t part = 0, number = 0;  // of the finder, and in it
    std::uint32_t surfel = 0;            // the first
    double domain = 0.0;                 // the radius of the largest domain that it may have
    double own = 0.0;                    // area in its object
    double joint = 0.0;                  // area among the disks of all objects
    double ended_domain = 0.0;           // the radius that it has
    std::vector<End> ends;               // of that
    bool is_open = false;                // in its object: at a border, or without neighbours that end it
    bool is_whole = true;                // as large as may be, without ends
    bool is_wanted = true;
};

class JointAreas {
public:
    JointAreas(const Scene& scene, const std::vector<char>& is_joined, const Progress& progress)
        : scene_(scene), s_(scene.surfels), progress_(progress), grid_(options_.resolution) {
        const std::vector<std::uint32_t> triangles = triangle_ranges(s_);
        std::vector<std::vector<std::uint32_t>> by_object(scene.object.back() + 1);
        std::vector<char> has_joined(by_object.size(), 0);
        for (std::uint32_t i = 0; i < s_.size(); ++i) {
            if (triangles[i] == triangles[i + 1]) by_object[scene.object[i]].push_back(i);
            if (is_joined[i]) has_joined[scene.object[i]] = 1;
        }
        for (std::size_t o = 0; o < by_object.size(); ++o)
            if (has_joined[o]) add(by_object[o], is_joined);
    }

    // First as if the domains of all were whole. Few have others around them that end: those are done again.
    const std::vector<Disk>& run(const std::vector<char>& has_own_areas) {
        std::vector<Vec3> positions;
        std::vector<double> domains;
        for (const Disk& disk : disks_) {
            positions.push_back(s_.positions[disk.surfel]);
            domains.push_back(disk.domain);
        }
        index_.emplace(positions, domains);
        for_each([&](Disk& disk, DiskIntegrator& integrator, Neighborhood& around) {
            const bool is_known = !has_own_areas.empty() && has_own_areas[scene_.object[disk.surfel]];
            disk.own = is_known ? given(disk) : bounded(integrator.area(around), disk);
            disk.is_open = around.ends.size() > around.crease_ends || around.radius < disk.domain;
            find_joint(disk, around);
            add_others(disk, around, false);
            disk.joint = around.others.empty() ? disk.own : bounded(integrator.area(around), disk);
            disk.is_whole = around.ends.empty() && !(around.radius < disk.domain);
            disk.ended_domain = around.radius;
            for (std::size_t e = 0; e < around.ends.size(); ++e) {
                const HalfPlane& side = around.ends[e];
                disk.ends.push_back({side.x * around.frame.u + side.y * around.frame.v, side.limit * around.radius,
                                     e >= around.crease_ends});
            }
        });
        mark_beside_ended();
        for_each([&](Disk& disk, DiskIntegrator& integrator, Neighborhood& around) {
            find_joint(disk, around);
            add_others(disk, around, true);
            disk.joint = around.others.empty() ? disk.own : bounded(integrator.area(around), disk);
        });
        return disks_;
    }

    // Of the surfels of the disk, as the scene has them.
    double given(const Disk& disk) const {
        double sum = 0.0;
        for (const std::uint32_t i : parts_[disk.part].finder->surfels(disk.number))
            sum += s_.areas[parts_[disk.part].surfels[i]];
        return sum;
    }

    std::vector<std::uint32_t> surfels(const Disk& disk) const {
        std::vector<std::uint32_t> out;
        for (const std::uint32_t i : parts_[disk.part].finder->surfels(disk.number))
            out.push_back(parts_[disk.part].surfels[i]);
        return out;
    }

private:
    // An object's disks.
    struct Part {
        std::vector<std::uint32_t> surfels;
        std::unique_ptr<NeighborhoodFinder> finder;
    };

    void add(const std::vector<std::uint32_t>& surfels, const std::vector<char>& is_joined) {
        Surfels of_object;
        for (const std::uint32_t i : surfels) {
            of_object.positions.push_back(s_.positions[i]);
            of_object.normals.push_back(s_.normals[i]);
            of_object.radii.push_back(s_.radii[i]);
        }
        const auto part = static_cast<std::uint32_t>(parts_.size());
        parts_.push_back({surfels, std::make_unique<NeighborhoodFinder>(
                                       of_object, std::vector<bool>(surfels.size(), true), options_.epsilon,
                                       standing_at(0, surfels.size(), progress_))});
        const NeighborhoodFinder& finder = *parts_.back().finder;
        for (std::uint32_t k = 0; k < finder.size(); ++k) {
            const std::uint32_t first = surfels[*finder.surfels(k).begin()];
            if (!is_joined[first]) continue;
            Disk disk;
            disk.part = part, disk.number = k, disk.surfel = first;
            disk.domain = domain_ratio * s_.radii[first];
            disks_.push_back(disk);
        }
    }

    template <class Body>
    void for_each(const Body& body) {
        parallel_blocks(
            disks_.size(), block,
            [&](std::size_t begin, std::size_t end) {
                DiskIntegrator integrator(options_, grid_);
                Neighborhood around;
                for (std::size_t d = begin; d < end; ++d) {
                    if (!disks_[d].is_wanted) continue;
                    parts_[disks_[d].part].finder->find(disks_[d].number, true, around);
                    body(disks_[d], integrator, around);
                }
            },
            progress_);
    }

    // Wanted are then those that have a disk beside them that is not whole.
    void mark_beside_ended() {
        std::vector<std::vector<std::uint32_t>> beside((disks_.size() + block - 1) / block);
        parallel_blocks(
            disks_.size(), block,
            [&](std::size_t begin, std::size_t end) {
                std::vector<Neighbor> near;
                for (std::size_t d = begin; d < end; ++d) {
                    if (disks_[d].is_whole) continue;
                    near.clear();
                    index_->reaching(s_.positions[disks_[d].surfel], disks_[d].domain, near);
                    for (const Neighbor& found : near)
                        if (is_one_surface(disks_[found.index].surfel, disks_[d].surfel))
                            beside[begin / block].push_back(found.index);
                }
            },
            progress_);
        for (Disk& disk : disks_) disk.is_wanted = false;
        for (const auto& some : beside)
            for (const std::uint32_t d : some) disks_[d].is_wanted = true;
    }

    double bounded(double area, const Disk& disk) const {
        return std::min(area, pi * s_.radii[disk.surfel] * s_.radii[disk.surfel]);
    }

    bool is_one_surface(std::uint32_t i, std::uint32_t j) const {
        return scene_.object[i] != scene_.object[j] && dot(s_.normals[i], s_.normals[j]) >= alike_normals &&
               (same_surface(scene_, i, j) || same_surface(scene_, j, i));
    }

    // The neighbourhood of a disk at a border of its object, which ends where none of the objects goes on.
    void find_joint(const Disk& disk, Neighborhood& around) const {
        if (!disk.is_open) return;
        const auto beside = [&](double distance, std::vector<Vec3>& places) {
            std::vector<Neighbor> near;
            index_->centered_within(s_.positions[disk.surfel], distance, near);
            for (const Neighbor& found : near)
                if (is_one_surface(disk.surfel, disks_[found.index].surfel))
                    places.push_back(s_.positions[disks_[found.index].surfel]);
        };
        parts_[disk.part].finder->curved(disk.number, around, beside);
    }

    // Disks of other objects stand on the surface that the disk's own neighbours agree on: scans are a little off.
    void add_others(const Disk& disk, Neighborhood& around, bool with_ends) const {
        thread_local std::vector<Neighbor> near;
        const ThreadScratch scratch(near);
        index_->reaching(s_.positions[disk.surfel], disk.domain, near);
        std::sort(near.begin(), near.end(), [](const Neighbor& a, const Neighbor& b) { return a.index < b.index; });
        for (const Neighbor& found : near) {
            const Disk& other = disks_[found.index];
            if (!is_one_surface(disk.surfel, other.surfel)) continue;
            const Vec3 offset = s_.positions[other.surfel] - s_.positions[disk.surfel];
            Vec3 position = in_frame(around.frame, offset / around.radius);
            position.z = around.model.height(position.x, position.y);
            const auto number = static_cast<std::uint32_t>(around.others.size());
            around.others.push_back({other.surfel, position, in_frame(around.frame, s_.normals[other.surfel]),
                                     (with_ends ? other.ended_domain : other.domain) / around.radius});
            if (!with_ends) continue;
            for (const End& end : other.ends) {
                const Vec3 normal = in_frame(around.frame, end.normal);
                const double limit = end.limit / around.radius + dot(normal, position);
                if (limit < length(normal) * reach) around.others_ends.push_back({number, normal, limit});
            }
        }
    }

    // How far from the middle places of a domain may be, on a surface that is bent.
    static constexpr double reach = 1.5;

    const Scene& scene_;
    const Surfels& s_;
    const Progress& progress_;
    const AreaOptions options_;
    const PolarGrid grid_;
    std::vector<Part> parts_;
    std::vector<Disk> disks_;
    std::optional<DiskIndex> index_;
};

struct Sums {
    double given = 0.0, own = 0.0, joint = 0.0;

    bool are_joint() const {
        constexpr double alike = 0.15;  // logarithm; slices of clouds fit within .03
        return given > 0.0 && own > 0.0 && joint > 0.0 && std::abs(std::log(given / joint)) < alike &&
               std::abs(std::log(given / joint)) < std::abs(std::log(given / own));
    }
};

}  // namespace

JointShares take_joint_shares(const Scene& scene, const std::vector<char>& is_joined, std::vector<double>& shares,
                              const std::vector<char>& has_own_areas, const Progress& progress) {
    if (std::find(is_joined.begin(), is_joined.end(), 1) == is_joined.end()) return {};
    JointAreas areas(scene, is_joined, progress);
    const std::vector<Disk>& disks = areas.run(has_own_areas);
    std::vector<Sums> sums(scene.object.back() + 1);
    for (const Disk& disk : disks) {
        Sums& sum = sums[scene.object[disk.surfel]];
        sum.given += areas.given(disk);
        sum.own += disk.own;
        sum.joint += disk.joint;
    }
    for (const Disk& disk : disks)
        if (disk.own > 0.0 && !sums[scene.object[disk.surfel]].are_joint())
            for (const std::uint32_t i : areas.surfels(disk)) shares[i] *= disk.joint / disk.own;
    JointShares out;
    for (std::uint32_t o = 0; o < sums.size(); ++o)
        if (sums[o].are_joint()) out.kept.push_back(o);
    for (const Disk& disk : disks)
        for (const End& end : disk.ends)
            if (end.is_border && end.limit < scene.surfels.radii[disk.surfel])
                for (const std::uint32_t i : areas.surfels(disk))
                    out.borders.push_back({end.normal, end.limit, i, DiskEnd::border});
    return out;
}

}  // namespace surflux
