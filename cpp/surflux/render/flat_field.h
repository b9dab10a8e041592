#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
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

    // RGB and nothing, so that it is added at once.
    using Value = std::array<float, 4>;

    // Of nodes, from those of surfels.
    void at_nodes(const std::vector<Rgb>& values, std::vector<Value>& out) const;
    Value at_pixel(std::size_t pixel, const std::vector<Value>& at_nodes) const {
        Value sum{};
        pixels.for_row(pixel, [&](std::uint32_t node, float w) {
            for (std::size_t c = 0; c < 4; ++c) sum[c] += w * at_nodes[node][c];
        });
        return sum;
    }
};

// Disks are blended by OpenGL's kernels (flat_image.h). Throws DeviceError where there are some, and no OpenGL.
FlatField flat_field(const Scene& scene, const PatchCorners& corners, const PixelPlaces& places, const Camera& camera,
                     bool culling = true, gl::Api api = gl::requested_api());

}  // namespace surflux
