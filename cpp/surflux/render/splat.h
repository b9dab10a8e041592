#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/progress.h"
#include "surflux/gl/context.h"
#include "surflux/render/camera.h"
#include "surflux/render/image_rows.h"
#include "surflux/render/kernel_walls.h"
#include "surflux/render/visible_emitter.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// Values of the surfels to be blended, each into an image of its own, black where nothing is seen.
struct SplatLayer {
    std::vector<Rgb> values;   // one for each surfel
    bool emitters_lit = true;  // else emitters are black in it
};

struct SplatOptions {
    double footprint = 1.5;  // kernel radius over the radius drawn (R, or less where areas show it is enough): from 1
                             // up, larger is smoother
    int samples = 1;         // samples x samples subpixels, averaged
    bool culling = true;     // else surfaces are seen from behind, too, in the colours of their fronts
    // Of each surfel: colours blend within one object alone. Empty: all are one.
    std::vector<std::int32_t> objects = {};
    const KernelWalls* walls = nullptr;  // as of DrawingOptions: for pictures of the same surfels
    ImageRows rows = {};                 // all that are drawn: the image has this height
};

// Throws ArgumentError, naming the argument, for what splat_image and flat_image do not take.
void check_splats(const Surfels& surfels, std::size_t width, std::size_t height, const SplatOptions& options);

// Rows from the top. All radiometric values linear, float32.
struct SplatImage {
    std::size_t width = 0, height = 0;
    std::vector<std::vector<float>> layers;  // 3 per pixel each
    std::vector<float> coverage;             // share of the subpixels that see a surface or an emitter
    // Of one subpixel, the middle one (the one right below the middle for even `samples`):
    std::vector<float> depth;         // along the view axis; infinity where nothing is seen
    std::vector<float> normal;        // 3 per pixel, world; 0 where nothing is seen
    std::vector<std::int32_t> index;  // of the surfel seen, -1 where nothing is, -2 - k for emitter k
};

// Surface splatting: one pass finds the surface that each pixel sees - disks of surfels without triangles, bent along
// the surface, and triangles -, and a second blends the values of all surfels around that point with elliptical
// Gaussians (object-space EWA, Ren, Pfister and Zwicker 2002), as wide as the surfels lie apart or as a subpixel sees,
// whichever is more. Drawn in bands of rows, between which `progress` is asked. Throws ArgumentError, and DeviceError
// where there is no GL.
SplatImage splat_image(const Surfels& surfels, const std::vector<SplatLayer>& layers,
                       const std::vector<VisibleEmitter>& emitters, const Camera& camera, std::size_t width,
                       std::size_t height, const SplatOptions& options = {}, const Progress& progress = {},
                       gl::Api api = gl::requested_api());

}  // namespace surflux
