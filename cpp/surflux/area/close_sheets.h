#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/neighbors/disk_index.h"
#include "surflux/scene/extent.h"
#include "surflux/scene/scene.h"

namespace surflux {

constexpr double alike_normals = 0.5;   // cosine between normals of one surface
constexpr double flat_normals = 0.999;  // of patches in one plane; where others meet, only a strip is as close
constexpr double close_disk = 0.25;     // of a disk's radius: a layer that near may be a scan that is misplaced

// What lies closely over or under a mesh and faces its way, but is not one with it: a scan over the mesh that was made
// of it, walls that are doubled a hair apart. The lower of the two gets no light. Whether they are one surface,
// geometry does not tell.
struct CloseSheet {
    std::uint32_t mesh = 0, other = 0;  // objects; one and the same where a mesh lies over itself
    std::size_t points = 0;             // of `other`, that lie over or under patches of `mesh`; 0: its patches lie over
    double area = 0.0;                  // of what they share, and the share that it has of all patches of `mesh`
    double share = 0.0;
    double height = 0.0;  // mean
};

// Patches that face each other, closer than rays can tell apart (Extent::contact) but not at one place: they exchange
// no light.
struct NarrowGap {
    std::uint32_t one = 0, other = 0;  // objects
    double area = 0.0;
    double width = 0.0;  // mean
};

// Finds them surfel by surfel: disks no farther from a patch than a quarter of their radius, and patches no more than
// 1e-4 of the scene's size over others of their plane, if farther than touching is. Const once made, for any number of
// threads.
class CloseSheetFinder {
public:
    CloseSheetFinder(const Scene& scene, const Extent& extent);

    // The patches that may be as close to surfel i, or touch it, not itself; ascending.
    void patches_near(std::uint32_t i, std::vector<std::uint32_t>& out) const;

    // Of one surfel and a mesh that it lies over or under, or of a patch and what lies over it.
    struct Meeting {
        std::uint32_t surfel, mesh, other;
        bool is_point;
        double area, height;  // no area of a point yet
    };
    void find(std::uint32_t i, const std::vector<std::uint32_t>& near, std::vector<Meeting>& out) const;

    // Of patch i and later ones: gaps, and the sides of one sheet.
    struct Facing {
        std::uint32_t one, other;
        double area, width;
    };
    void find_facing(std::uint32_t i, const std::vector<std::uint32_t>& near, std::vector<Facing>& out,
                     std::vector<Sheet>& sheets) const;
    static std::vector<NarrowGap> gaps(const std::vector<std::vector<Facing>>& facing);

    // What all meetings come to, ascending; of two objects first points over the mesh.
    std::vector<CloseSheet> sheets(const std::vector<std::vector<Meeting>>& meetings, const Progress& progress) const;

private:
    bool is_patch(std::uint32_t i) const { return triangles_[i] != triangles_[i + 1]; }
    void disk(std::uint32_t i, const std::vector<std::uint32_t>& near, std::vector<Meeting>& out) const;
    void patch(std::uint32_t i, const std::vector<std::uint32_t>& near, std::vector<Meeting>& out) const;
    void set_areas(std::vector<Meeting>& points, const Progress& progress) const;

    const Scene& scene_;
    const Surfels& s_;
    const Extent& extent_;
    std::vector<std::uint32_t> triangles_, patches_;
    std::unique_ptr<DiskIndex> index_;  // of the patches, where there are any
};

}  // namespace surflux
