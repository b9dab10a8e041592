#pragma once

#include <vector>

#include "surflux/gl/context.h"
#include "surflux/render/patch_corners.h"
#include "surflux/render/pixel_places.h"
#include "surflux/scene/scene.h"

namespace surflux {

// A hierarchy of functions flattened for drawing (L07 section 6.2): what pixels see of the values of surfels, as two
// sparse products, which cost the same whatever the values came from. Patches are interpolated between their corners,
// disks blend as splats do.
struct FlatField {
    SparseRows nodes;   // over surfels: the corners of patches in view, and disks
    SparseRows pixels;  // over nodes; each row makes 1, of pixels that see nothing it is empty

    // By pixel, 3 each; values by surfel.
    void draw(const std::vector<Rgb>& values, std::vector<float>& out) const;
};

// Disks are blended by OpenGL's kernels (flat_image.h). Throws DeviceError where there are some, and no OpenGL.
FlatField flat_field(const Scene& scene, const PatchCorners& corners, const PixelPlaces& places, const Camera& camera,
                     bool culling = true, gl::Api api = gl::requested_api());

}  // namespace surflux
