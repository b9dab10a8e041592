#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/scene/surfels.h"

namespace surflux {

struct InwardOptions {
    std::size_t smallest = 20;  // surfels of a patch; fewer are noise
    int rays = 8;               // from each side of a surfel that is asked
    std::uint64_t seed = 0;
    bool rooms = false;  // a sheet that closes around a body may be a room, seen from inside
};

struct Inward {
    std::vector<std::uint32_t> patch;  // per surfel: 0, or the number of its patch, 1 for the largest
    std::vector<char> unsure;          // per surfel: where normals change sides, and nothing tells which are right
};

// Patches of surfels whose normals point inwards. Sheets, and which side of them is seen, are those of sheet_sides. In
// an open sheet the side that most of its surfels face is right; so it is in any sheet with `rooms`, for nothing tells
// an empty room from a body turned inside out.
Inward inward_patches(const Surfels& surfels, const InwardOptions& options, const Progress& progress = {});

}  // namespace surflux
