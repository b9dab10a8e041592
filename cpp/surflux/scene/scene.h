#pragma once

#include <cstdint>
#include <vector>

#include "surflux/scene/lights.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// Two patches that face the same way lie in one place, in part or altogether: `above`, the later of the two, is what is
// seen there, as the last coat of paint is.
struct Cover {
    std::uint32_t below, above;
};

// Two patches that face opposite ways lie in one place, within contact, in part or altogether: the sides of one sheet,
// as faces are that a mesh has both ways round, or the walls of adjoining rooms. Each is met from its own side. So is
// the floor under a box that stands on it: what it sees is the inside of the box.
struct Sheet {
    std::uint32_t one, other;
};

// All surfels of a scene in one list, and the object (reconstruction group, L07 6.1) that each belongs to.
struct Scene {
    Surfels surfels;
    std::vector<std::uint32_t> object;  // per surfel
    std::vector<Light> lights;
    // Filled in by count_once (area/coincidence.h), empty where nothing coincides. Covers ascend; the spread of a disk
    // that shares its surface with disks of other objects is how far off its plane those may lie, and 0 for all others.
    std::vector<Cover> covers;
    std::vector<Sheet> sheets;
    std::vector<double> spread;  // per surfel, or empty
};

// May disks i and j stand for the same surface: of one object, or within the spread of their heights?
bool same_surface(const Scene& scene, std::uint32_t i, std::uint32_t j);

// Throws ArgumentError where areas are missing, or one is not a positive number.
void require_areas(const Scene& scene);

// Appends the surfels as a new object. Areas must be given for all objects or for none.
void append(Scene& scene, const Surfels& surfels);

// The same without areas and ends of disks.
void append_shapes(Scene& scene, const Surfels& surfels);

}  // namespace surflux
