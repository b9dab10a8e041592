#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/extent.h"
#include "surflux/scene/scene.h"

namespace surflux {

// Two objects whose disks overlap and face alike, as registered scans do.
struct Overlap {
    std::uint32_t one, other;  // objects, ascending
    std::size_t joined = 0;    // disks of either that sample one surface with disks of the other
    std::size_t layered = 0;   // disks of either that the other's lie closely over: another sheet, or so it is taken
    double height = 0.0;       // mean, of those
};

// All empty where no disks of two objects overlap.
struct DiskOverlaps {
    std::vector<double> spread;     // of each surfel, see Scene
    std::vector<char> is_joined;    // of each surfel: is there a disk of another object on the same surface?
    std::vector<Overlap> overlaps;  // ascending
};

// Tells overlapping scans of one surface from layers: disks of different objects are one where each lies within the
// other's reach, normals are within 60 degrees, and the height of one over the other's plane is no more than four times
// the RMS of what disks of the same object have there: noise, and curvature. What is farther off is a sheet of its own,
// as a leaf on a floor is. Disks of an object that are piled up at one place are looked at once.
DiskOverlaps find_disk_overlaps(const Scene& scene, const Extent& extent, const Progress& progress = {});

}  // namespace surflux
