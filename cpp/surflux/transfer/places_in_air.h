#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/core/vec.h"
#include "surflux/lights/sample_points.h"
#include "surflux/scene/surfels.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// From each place the mean length of rays as far as they meet something, or of distant light (`of_lamps` false) the
// share of them that escapes.
std::vector<double> free_paths(const SurfelPoints& points, const Tracer& tracer, const std::vector<Place>& places,
                               bool of_lamps, std::uint64_t seed, const Progress& progress);

// `count` random places in the air in front of surfaces, even in its volume, within `region` where there is one. `air`:
// how much of it is in front of each of `receivers`: the area that it stands for times the mean length of its rays. No
// surface is nearer than `clearance`, or, where there is little such room, than a half, a quarter and so on of it. None
// where there is no air; an ArgumentError where the region holds none.
std::vector<Vec3> places_in_air(const SurfelPoints& points, const Tracer& tracer, const std::vector<Place>& receivers,
                                const std::vector<double>& air, const std::optional<Box>& region, double clearance,
                                std::size_t count, std::uint64_t seed, const Progress& progress = {});

}  // namespace surflux
