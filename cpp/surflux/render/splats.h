#pragma once

// Surfels, triangles and emitters as the GL draws them: in the camera's frame, float32 relative to the eye.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/render/camera.h"
#include "surflux/render/kernel_walls.h"
#include "surflux/render/screen_bounds.h"
#include "surflux/render/visible_emitter.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// As the shaders read them (std430).

// A disk, bent along the surface (bends.h).
struct DrawnDisk {
    float center[3], radius;
    float normal[3], along;
    float direction[3], across;
    float sag;  // see surface_fragment
    std::int32_t index, group;
    float unused;
    float creases[2][4];  // where it ends: normal . (p - center) <= the fourth
    std::int32_t box[4];  // pixels that it may cover: left, top, right, bottom
};

// What a surfel adds to the pixels around it: an elliptical Gaussian, brought to 0 at the rim of an ellipsoid.
struct DrawnKernel {
    float center[3];
    std::int32_t group;
    float normal[3], amplitude;
    float direction[3], agreement;  // the long axis in its plane; see kernel_fragment
    float shrink[3];                // 1 / half axis^2: along the direction, across, along the normal
    std::int32_t index;
    std::int32_t box[4];
    std::int32_t walls[2], unused[2];  // the first that stands in its way, and the one after the last
};

struct FlatTriangle {
    float corners[3][4];
    float normal[3];
    std::int32_t index;
    std::int32_t group, unused[3];
};

struct PixelGrid {
    int width, height;    // subpixels
    double tan_x, tan_y;  // of half the field of view; of a parallel projection half its width and height
    bool parallel = false;
};

// In view, as far as is easy to tell.
struct DrawnGeometry {
    std::vector<DrawnDisk> disks;
    std::vector<DrawnKernel> kernels;
    std::vector<WallTrace> walls;
    std::vector<FlatTriangle> triangles;
    double far_depth = 0.0;
};

struct DrawingOptions {
    double footprint = 1.5;  // as of SplatOptions
    bool culling = true;
    bool kernels = true;                 // else only what the surface pass needs
    const KernelWalls* walls = nullptr;  // of the surfels, with this footprint; nullptr: they are found
};

inline void store(float* to, const Vec3& from) {
    for (int axis = 0; axis < 3; ++axis) to[axis] = static_cast<float>(from[axis]);
}

inline Vec3 stored(const float* at) { return {at[0], at[1], at[2]}; }

// objects: of each surfel; light blends within one alone. Throws ArgumentError, naming `emitters`, for one that is no
// rectangle.
DrawnGeometry drawn_geometry(const Surfels& surfels, const std::vector<std::int32_t>& objects,
                             const std::vector<VisibleEmitter>& emitters, const CameraFrame& frame,
                             const PixelGrid& grid, const DrawingOptions& options = {});

}  // namespace surflux
