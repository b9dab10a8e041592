#pragma once

#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/render/camera.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// A place that OpenGL found on a patch, of triangles [begin, end), put into its plane: depths are floats, and those of
// GPUs are off by more than what touches a surface, so that rays from there would begin beneath it.
Vec3 onto_patch(const std::vector<Triangle>& triangles, std::uint32_t begin, std::uint32_t end, const Vec3& place);

// What pixels see, world: of rows [top, top + depths / width) of a picture, from the depth and the surfel that a pass
// found for each. 0 where there is none.
std::vector<Vec3> seen_places(const Surfels& surfels, const Camera& camera, std::size_t width, std::size_t height,
                              std::size_t top, const std::vector<float>& depths,
                              const std::vector<std::int32_t>& indices);

}  // namespace surflux
