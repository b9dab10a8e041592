#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/gl/context.h"
#include "surflux/render/camera.h"
#include "surflux/trace/compiled_scene.h"

namespace surflux {

// The ray of each pixel of a picture, through the middle of it.
struct PixelRays {
    CameraFrame frame;
    std::size_t width = 0, height = 0;
    double step = 0.0;  // of a pixel: at depth 1, or of a parallel projection anywhere

    PixelRays() = default;
    PixelRays(const Camera& camera, std::size_t width, std::size_t height);
    Vec3 origin(double x, double y) const { return frame.parallel ? frame.eye + across(x, y) : frame.eye; }
    // Its length along the view axis is 1.
    Vec3 direction(double x, double y) const { return frame.parallel ? frame.forward : frame.forward + across(x, y); }
    // Of a pixel at a depth.
    double size_at(double depth) const { return frame.parallel ? step : step * depth; }

private:
    Vec3 across(double x, double y) const {
        return step * ((x + 0.5 - 0.5 * static_cast<double>(width)) * frame.right +
                       (y + 0.5 - 0.5 * static_cast<double>(height)) * frame.down);
    }
};

// The place on a surface that each pixel sees: on a patch exactly where the ray meets it, to the rounding of a float.
// Rows from the top.
struct PixelPlaces {
    static constexpr std::uint32_t none = 0xffffffffu;

    PixelRays rays;
    std::vector<std::uint32_t> surfel;    // none where nothing is seen
    std::vector<std::uint32_t> triangle;  // of its patch; none on a disk
    std::vector<float> depth;             // along the view axis; infinity where nothing is seen
    std::vector<float> offset;            // 3 a pixel: from the eye, in the axes of the world
    std::vector<float> normal;            // 3 a pixel: of the surfel's front, whichever side is seen

    std::size_t size() const { return surfel.size(); }
    bool is_seen(std::size_t pixel) const { return surfel[pixel] != none; }
    Vec3 place(std::size_t pixel) const { return rays.frame.eye + three(offset, pixel); }
    Vec3 normal_at(std::size_t pixel) const { return three(normal, pixel); }

private:
    static Vec3 three(const std::vector<float>& of, std::size_t pixel) {
        const float* from = of.data() + 3 * pixel;
        return {static_cast<double>(from[0]), static_cast<double>(from[1]), static_cast<double>(from[2])};
    }
};

// Scenes of patches alone are seen by rays, in a third of the time that llvmpipe takes and without OpenGL; disks, bent
// along their surface, as pictures draw them (surface_pass.h). culling: else surfaces are seen from behind, too.
// Throws ArgumentError, and DeviceError where there are disks and no OpenGL.
PixelPlaces pixel_places(const CompiledScene& scene, const Camera& camera, std::size_t width, std::size_t height,
                         bool culling = true, gl::Api api = gl::requested_api());

// Of a triangle, the weights of its corners at a point in its plane; they make 1.
Vec3 corner_weights(const Triangle& triangle, const Vec3& point);

}  // namespace surflux
