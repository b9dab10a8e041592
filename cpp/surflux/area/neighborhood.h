#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "surflux/area/border.h"
#include "surflux/area/effective_area.h"
#include "surflux/area/surface_fit.h"
#include "surflux/core/span.h"
#include "surflux/neighbors/disk_index.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// A surfel as another one's disk sees it: in the frame (u, v, n_i) and in units of its domain's radius.
struct Member {
    std::uint32_t surfel;
    Vec3 position, normal;
    double radius;
};

// A half plane that member number `member` ends at, in the same frame and units: dot(normal, p) <= limit.
struct MemberEnd {
    std::uint32_t member;
    Vec3 normal;
    double limit;
};

// The adjacency of disk i: who shares it, and the half planes that clip it.
struct Neighborhood {
    Frame frame;
    double radius = 0.0;          // of the domain, in the unit of the positions
    std::vector<Member> surface;  // i itself first, then its neighbours on the same surface: n_i . n_j > epsilon

    // The rest serves the curved method alone.
    std::vector<Member> crease;   // neighbours around a crease that does not end the disk: they share it
    std::vector<HalfPlane> ends;  // the disk's domain lies within all of them: creases, then borders
    std::size_t crease_ends = 0;  // how many of them are creases
    SurfaceModel model;

    // Disks of other objects that sample the same surface, and where they end, in their order (joint_areas.h). The
    // finder knows one object and leaves both empty.
    std::vector<Member> others;
    std::vector<MemberEnd> others_ends;
};

Vec3 in_frame(const Frame& frame, const Vec3& v);

// Appends the places of other objects' disks that sample the surface of one, and are no farther from it.
using Beside = std::function<void(double distance, std::vector<Vec3>& places)>;

// Finds the neighbourhoods of disks; const once made, for any number of threads.
class NeighborhoodFinder {
public:
    // Of those surfels for which `is_disk` holds.
    NeighborhoodFinder(const Surfels& surfels, const std::vector<bool>& is_disk, double epsilon,
                       const Progress& progress = {});

    // Disks are numbered here in Morton order; which surfels disk i is, surfels(i) says: one, or a pile of them
    // (neighbors/piles.h), which have the area of the first in equal parts.
    std::size_t size() const { return disks_.size(); }
    Span<std::uint32_t> surfels(std::size_t i) const {
        return {surfels_.data() + begin_[i], surfels_.data() + begin_[i + 1]};
    }
    double radius(std::size_t i) const { return disks_[i].radius; }

    void find(std::size_t i, bool for_curved, Neighborhood& out) const { for_curved ? curved(i, out) : flat(i, out); }

    // Frame, radius and surface, for D04's method: every disk that reaches disk i and is of its surface.
    void flat(std::size_t i, Neighborhood& out) const;

    // For the curved method:
    //
    // Layers. Of the disks with n_i . n_j > epsilon, those that lie high over disk i, while i lies high over theirs,
    // are another layer (a stair, a sheet over a sheet) and have no part in disk i.
    //
    // Creases. A neighbour with n_i . n_j <= epsilon lies around an edge. Where i and its surface stay on one side of
    // j's plane, and j and those of its direction on the same side of i's (both behind: a convex edge; both before: a
    // concave one), disk i ends at j's plane. Where they do not, the surface is only coarsely sampled: then j shares
    // the disk by distance.
    //
    // Borders. Beyond the sampling there is no surface: the disk ends with the convex hull of the points around i,
    // as seen along n_i, without sides that only bevel a corner, plus a small part of their spacing, for the true
    // border passes outside of its outermost samples. Where `beside` finds samples of other objects, the surface goes
    // on: they are points of the hull, too, out to twice the disk's spacing.
    //
    // Domains. Disks that just cover the surface together leave slits where it bends, and their weights would end where
    // others' are still needed: each counts up to domain_ratio times its radius, unless it has no neighbours to end it.
    //
    // The surface is the model that the neighbours agree on, and they stand on it themselves: what noise lifts a point
    // off its neighbours' surface does not make it farther.
    void curved(std::size_t i, Neighborhood& out, const Beside& beside = {}) const;

private:
    // Frame, radius, surface and crease, with `ratio` times every radius.
    void gather(std::size_t i, double ratio, Neighborhood& out) const;
    // The same for the curved method, complete. False where no neighbours end the domain.
    bool complete(std::size_t i, double ratio, Neighborhood& out, const Beside& beside) const;
    void add_creases(const std::vector<Member>& around, Neighborhood& out) const;
    bool add_borders(std::size_t i, const std::vector<Member>& around, Neighborhood& out, const Beside& beside) const;

    struct Disk {
        Vec3 position, normal;
        double radius;
        std::uint32_t surfel;
    };
    // In Morton order, so that what a search finds lies together in memory too.
    std::vector<Disk> disks_of(const Surfels& surfels, const std::vector<bool>& is_disk,
                               const Progress& progress);  // fills in surfels_, too
    template <class T>
    static std::vector<T> of_each(const std::vector<Disk>& disks, T Disk::* member);

    double epsilon_;
    std::vector<std::uint32_t> surfels_, begin_;  // of disk i those from begin_[i] to begin_[i + 1]
    std::vector<Disk> disks_;
    DiskIndex index_;
};

// Throws ArgumentError where radii are of a size that has no squares.
void require_radii(const NeighborhoodFinder& finder);

// Gives the surfels of a disk its area in equal parts; of the curved method at most that of the flat disk.
void take_area(const NeighborhoodFinder& finder, std::size_t disk, AreaMethod method, double area,
               std::vector<double>& areas);

}  // namespace surflux
