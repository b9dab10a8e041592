#pragma once

#include <cstdint>
#include <vector>

#include "surflux/meshless/meshless_field.h"
#include "surflux/render/camera.h"
#include "surflux/render/seen_tiles.h"
#include "surflux/render/surface_pass.h"

namespace surflux {

// A function as the shaders of meshless_shaders.h read it (std430).
struct DrawnSupport {
    float center[3], shrink;  // 1 / r^2
    float normal[3], object;
    float all[3], nearest;  // depth of the support's nearest point, over the view's far depth
    float direct[3], filler;
    float value[3], gathered;  // MeshlessField::values, 0 and 0 of those without
    float direct_value[3], another_filler;
    float corners[4];  // of the rectangle that it is drawn in: left, top, right, bottom, from -1 to 1
    float cuts[2][4];  // planes that end it: normal and offset; 0 0 0 -1 for none
};

// Pixels that a ball around a place, from the eye, may cover; rows from the top of the view's.
SeenTiles::Rectangle box_of(const Vec3& center, double radius, const DrawnView& view);

// The functions of a level that may speak where a pixel sees something, and where that is. Places of pixels and of
// functions are relative to the origin, in the camera's frame.
std::vector<DrawnSupport> seen_supports(const MeshlessField& field, const std::vector<std::uint32_t>& functions,
                                        const CameraFrame& frame, const Vec3& origin, const DrawnView& view,
                                        const SeenTiles& tiles);

}  // namespace surflux
