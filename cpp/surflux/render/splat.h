#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/gl/context.h"
#include "surflux/render/camera.h"
#include "surflux/render/visible_emitter.h"
#include "surflux/scene/surfels.h"

namespace surflux {

struct SplatOptions {
    Rgb background;          // radiance where no surface is seen
    double footprint = 1.5;  // kernel radius over the radius drawn (R, or less where areas show it is enough): from 1
                             // up, larger is smoother
    int samples = 1;         // samples x samples subpixels, averaged
    // Of each surfel: colours blend within one object alone. Empty: all are one.
    std::vector<std::int32_t> objects = {};
};

// Rows from the top. All radiometric values linear, float32.
struct SplatImage {
    std::size_t width = 0, height = 0;
    std::vector<float> radiance;  // 3 per pixel
    std::vector<float> coverage;  // fraction of the subpixels that see a surface or an emitter
    // Of one subpixel, the middle one (the one right below the middle for even `samples`):
    std::vector<float> depth;         // along the view axis; infinity where nothing is seen
    std::vector<float> normal;        // 3 per pixel, world; 0 where nothing is seen
    std::vector<std::int32_t> index;  // of the surfel seen, -1 where nothing is, -2 - k for emitter k
};

// Surfels as blended disks (Botsch and Kobbelt 2003): one pass finds the surface that each pixel sees - disks of
// surfels without triangles, and triangles, front faces only -, a second blends the radiance of all surfels around that
// point with a smooth kernel. `radiance` has one value per surfel. Throws ArgumentError, and DeviceError where there is
// no GL.
SplatImage splat_image(const Surfels& surfels, const std::vector<Rgb>& radiance,
                       const std::vector<VisibleEmitter>& emitters, const Camera& camera, std::size_t width,
                       std::size_t height, const SplatOptions& options = {}, gl::Api api = gl::requested_api());

}  // namespace surflux
