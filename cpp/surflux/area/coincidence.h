#pragma once

#include <vector>

#include "surflux/area/close_sheets.h"
#include "surflux/area/disk_overlap.h"
#include "surflux/core/progress.h"
#include "surflux/scene/scene.h"

namespace surflux {

// Surfels of an object so far from the middle of the scene, or so small, that rays cannot tell them from what is beside
// them: places there are rounded by more than their radius.
struct Coarse {
    std::uint32_t object = 0;
    std::size_t surfels = 0;
    double contact = 0.0;  // the largest distance within which surfaces there touch
};

// An object whose disks emit and have been given areas, other than those of the disks as rays meet them.
struct UnlikeAreas {
    std::uint32_t object = 0;
    double ratio = 1.0;  // of the power by what is given, over that by the disks' own
};

// Coincident geometry that faces the same way, which a rasterizer would show as z-fighting: a carpet modelled into a
// floor, two scans of one wall.
struct Coincidence {
    std::vector<Cover> covers;
    std::vector<double> uncovered;  // of each patch, the share of it that no later patch covers; 1 of disks
    std::vector<CloseSheet> close_sheets;
    std::vector<NarrowGap> gaps;  // ascending
    std::vector<Sheet> sheets;
    DiskOverlaps disks;
    std::vector<Coarse> coarse;             // ascending
    std::vector<UnlikeAreas> unlike_areas;  // ascending; found by compile_scene
};

// Patches coincide within twice the contact distance, as far as triangles overlap there; what of disks does,
// disk_overlap.h says.
Coincidence find_coincidence(const Scene& scene, const Progress& progress = {});

// Puts it into the scene. Areas, where there are any, count once: a patch keeps what is not covered, and a billionth,
// so that it stays; disks share (joint_areas.h), and those that do end where none of their objects goes on, if there
// are ends. Returned are the objects whose areas do so already. `has_own_areas` marks those whose areas were found by
// effective_areas().
std::vector<std::uint32_t> count_once(Scene& scene, const Coincidence& found, const Progress& progress = {},
                                      const std::vector<char>& has_own_areas = {});

}  // namespace surflux
