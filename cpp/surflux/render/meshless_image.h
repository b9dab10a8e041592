#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/gl/context.h"
#include "surflux/meshless/meshless_field.h"
#include "surflux/render/camera.h"
#include "surflux/render/drawn_functions.h"
#include "surflux/render/image_rows.h"
#include "surflux/render/parted_surfels.h"
#include "surflux/render/visible_emitter.h"
#include "surflux/scene/scene.h"

namespace surflux {

// Rows from the top, of subpixels, one sample in the middle of each.
struct MeshlessImage {
    std::size_t width = 0, height = 0;
    std::vector<float> all, direct;    // 3 per pixel: irradiance in the basis, and the part of it that is direct light
    std::vector<float> depth;          // along the view axis; infinity where nothing is seen
    std::vector<float> normal;         // 3 per pixel, world, of the front; 0 where no surfel is seen
    std::vector<std::int32_t> index;   // of the surfel seen, -1 where nothing is, -2 - k for emitter k
    std::vector<Vec3> position;        // of what is seen, world; 0 where no surfel is
    std::vector<std::uint8_t> parted;  // 1: of a surfel that walls part from some functions, which do not speak here
    std::vector<std::uint8_t> hidden;  // 1: all functions that reach it are behind walls, and it has no light here
    std::size_t fallbacks = 0;         // subpixels that no function of the coarsest level covers
};

// A field in its basis, as the camera sees it (L07 6.2): surfaces first (surface_pass.h), then level by level a
// rectangle around each function that may be in view, weights and weighted coefficients and values added up, and what
// LevelLight makes of them added to the image. Where none covers the coarsest level the nearest function speaks, as in
// MultilevelBasis::at_level: those few pixels are evaluated on the CPU, as are those on surfels that walls part from
// some functions (nullptr: from none), and subpixels with light of their own where these are few. Throws ArgumentError,
// and DeviceError where there is no GL. The image has the height of the rows drawn. samples: subpixels a side of a
// pixel, over which light is one where they see one smooth piece of a surface (light_pixels.h); sizes and rows are
// multiples of it. culling: else surfaces are seen from behind, too, in the light of their fronts.
MeshlessImage meshless_image(const MeshlessField& field, const DrawnFunctions& functions, PartedSurfels* parted,
                             const Scene& scene, const std::vector<VisibleEmitter>& emitters, const Camera& camera,
                             std::size_t width, std::size_t height, int samples, const ImageRows& rows = {},
                             bool culling = true, gl::Api api = gl::requested_api());

}  // namespace surflux
