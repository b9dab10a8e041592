#pragma once

#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/scene.h"

namespace surflux {

// Two objects whose disks overlap and face alike.
struct Overlap {
    std::uint32_t one, other;  // objects, ascending
    std::size_t joined = 0;    // disks of either that stand for one surface with disks of the other
    std::size_t layered = 0;   // disks of either that the other's lie closely over: another sheet, or so it is taken
    double height = 0.0;       // mean, of those
};

// Where surfels of a scene coincide and face the same way, found by geometry alone: a carpet modelled into a floor, two
// scans of one wall.
struct Coincidence {
    std::vector<Cover> covers;
    std::vector<double> uncovered;  // of each patch, the share of it that no later patch covers; 1 of disks
    std::vector<double> spread;     // of each disk, see Scene
    std::vector<char> is_joined;    // of each disk: is there one of another object on the same surface?
    std::vector<Overlap> overlaps;  // ascending
};

// Patches coincide within twice the contact distance, as far as triangles overlap there. Disks of different objects are
// one surface where each lies within the other's reach, normals are within 60 degrees, and the height of one over the
// other's plane is no more than four times the RMS of what disks of the same object have there: noise, and curvature.
// What is farther off is a sheet of its own, as a leaf on a floor is.
Coincidence find_coincidence(const Scene& scene, const Progress& progress = {});

// Puts it into the scene. Areas, where there are any, count once: a patch keeps what is not covered, and a billionth,
// so that it stays; disks keep one over the number of objects that cover the same place, each as far as its ends.
void count_once(Scene& scene, const Coincidence& found);

}  // namespace surflux
