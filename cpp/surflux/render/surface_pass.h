#pragma once

// What the passes of this room share: surfels, triangles and emitters as the GL draws them, and the pass that finds the
// surface that each pixel sees.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "surflux/gl/objects.h"
#include "surflux/render/camera.h"
#include "surflux/render/visible_emitter.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// As the shaders read them (std430): camera frame, float32 relative to the eye.
struct Splat {
    float center[3], kernel;
    float normal[3], disk;  // disk radius; 0 for a surfel that triangles stand for
    float radiance[3];
    std::int32_t index;
};

struct FlatTriangle {
    float corners[3][4];
    float normal[3];
    std::int32_t index;
};

// In view, as far as is easy to tell.
struct DrawnGeometry {
    std::vector<Splat> splats;
    std::vector<FlatTriangle> triangles;
    double far_depth = 0.0;
};

inline void store(float* to, const Vec3& from) {
    for (int axis = 0; axis < 3; ++axis) to[axis] = static_cast<float>(from[axis]);
}

// Kernels of disks and patches reach `footprint` times as far as what is drawn of them. Throws ArgumentError, naming
// `emitters`, for one that is no rectangle.
DrawnGeometry drawn_geometry(const Surfels& surfels, const std::vector<Rgb>& radiance,
                             const std::vector<VisibleEmitter>& emitters, const CameraFrame& frame, double footprint);

// Primitives in buffers of a size that every driver takes in one block (128 MiB is promised).
template <class Primitive>
class DrawBatches {
public:
    DrawBatches(const gl::Functions& gl, const std::vector<Primitive>& primitives)
        : gl_(gl), total_(primitives.size()) {
        for (std::size_t begin = 0; begin < total_; begin += batch) {
            buffers_.emplace_back(gl, primitives.data() + begin, std::min(batch, total_ - begin) * sizeof(Primitive));
        }
    }

    void draw(int vertices_each) const {
        for (std::size_t i = 0; i < buffers_.size(); ++i) {
            buffers_[i].bind(0);
            const std::size_t count = std::min(batch, total_ - i * batch);
            gl_.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(count) * vertices_each);
        }
    }

private:
    static constexpr std::size_t batch = 1u << 20;
    const gl::Functions& gl_;
    std::size_t total_;
    std::deque<gl::Buffer> buffers_;
};

// Pixels of an image, and how the shaders of splat_shaders.h are told of them.
struct DrawnView {
    GLsizei width, height;
    float tan_x, tan_y;  // of half the field of view
    float near_depth, far_depth;

    DrawnView(GLsizei width, GLsizei height, double tan_half, double far_depth);
    // Makes the program current and sets what it shares with the others.
    void use(const gl::Functions& gl, const gl::Program& program) const;
};

// Throws ArgumentError, naming `size`, for what the device cannot draw, and DeviceError for one that lacks the means.
void check_drawable(const gl::Functions& gl, GLsizei width, GLsizei height);

// The surface that each pixel sees: disks of surfels without triangles, and triangles, front faces only.
struct SurfacePass {
    SurfacePass(const gl::Functions& gl, const DrawnView& view, const DrawnGeometry& geometry,
                const DrawBatches<Splat>& splats);

    gl::Texture surface;  // RGBA32F: depth along the view axis, normal in the camera's frame
    gl::Texture seen;     // R32I: surfel, -1 where nothing is, -2 - k for emitter k
    gl::Texture depth;    // linear, over the view's far depth
    gl::Framebuffer target;
};

}  // namespace surflux
