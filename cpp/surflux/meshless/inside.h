#pragma once

#include <cstdint>
#include <vector>

#include "surflux/meshless/tuning.h"
#include "surflux/scene/scene.h"
#include "surflux/trace/tracer.h"

namespace surflux {

// Does the ray from each place along its normal meet the back of a surface first (L07 6.1)?
std::vector<char> under_backs(const Scene& scene, const Tracer& tracer, const std::vector<Departure>& places);

// Are the places inside geometry? Departing from L07 6.1, which takes the one ray's word: what is under a back, too, is
// inside only if twelve more rays, six steep and six flat ones, all meet backs: the floor below a table whose underside
// no scanner saw has light from the sides. The twelve are rotated about the normal at random, the same for the same
// seed and place.
std::vector<char> inside_geometry(const Scene& scene, const Tracer& tracer, const std::vector<Departure>& places,
                                  std::uint64_t seed, const MeshlessTuning& tuning = {});

}  // namespace surflux
