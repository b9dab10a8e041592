#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"
#include "surflux/scene/surfels.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// In which of d directions does light from afar reach surfels, at their places? A row of bytes for each surfel, a bit
// for each direction, the first in the highest bit (numpy's packbits): set where the surfel faces the direction and
// nothing is in the way.
struct FreeDirections {
    std::size_t directions = 0;
    std::vector<std::uint8_t> bits;

    static std::size_t row_bytes(std::size_t directions) { return (directions + 7) / 8; }
};

// A shadow ray from the place of each of the surfels `which`, by their index, to every direction that it faces; in
// scenes with triangles those of neighbours that go the same way, sixteen at once. `directions`: unit vectors.
FreeDirections find_free_directions(const Surfels& surfels, const std::vector<std::uint32_t>& which,
                                    const Tracer& tracer, const std::vector<Vec3>& directions,
                                    const Progress& progress = {});

// What parallel light of each direction brings to planes with some normals: the sum of max(0, n . v_j) over all of the
// vectors v_j, `unoccluded`, and over those whose bit is set, `arrived`. Without the cosine: the sum of |v_j| of those
// that are faced. `bits`: a row for each normal.
struct DirectionSums {
    std::vector<double> arrived, unoccluded;
};
DirectionSums sum_directions(const std::vector<Vec3>& normals, const std::uint8_t* bits,
                             const std::vector<Vec3>& vectors, bool cosine);

}  // namespace surflux
