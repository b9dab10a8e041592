#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"

namespace surflux {

// Indices, ascending, of `count` of the points that are spread as evenly as they can be: blue noise by weighted
// sample elimination (Yuksel 2015), alpha = 8, beta = 0.65, gamma = 1.5. `area` is that of the sampled surface; it sets
// the distance r_max at which points begin to crowd each other. Where more than 8 points share a cubic cell of side
// r_max, 8 of them at random come into question (more, where `count` needs more). Otherwise the seed only decides
// between equals.
std::vector<std::uint32_t> eliminate_samples(std::vector<Vec3> points, std::size_t count, double area,
                                             std::uint64_t seed, const Progress& progress = {});

}  // namespace surflux
