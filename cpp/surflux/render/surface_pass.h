#pragma once

// What the passes of this room share: primitives in buffers, the view, and the pass that finds the surface that each
// pixel sees.

#include <algorithm>
#include <cstddef>
#include <deque>
#include <vector>

#include "surflux/gl/objects.h"
#include "surflux/render/splats.h"

namespace surflux {

// Primitives in buffers of a size that every driver takes in one block (128 MiB is promised).
template <class Primitive>
class DrawBatches {
public:
    DrawBatches(const gl::Functions& gl, const std::vector<Primitive>& primitives, std::size_t each = 1)
        : gl_(gl), total_(primitives.size() / each) {
        for (std::size_t begin = 0; begin < total_; begin += batch) {
            buffers_.emplace_back(gl, primitives.data() + begin * each,
                                  std::min(batch, total_ - begin) * each * sizeof(Primitive));
        }
    }

    void draw(int vertices_each) const {
        for (std::size_t i = 0; i < buffers_.size(); ++i) draw(i, vertices_each);
    }
    // Together with what else goes by the same numbers, in binding 1.
    template <class Other>
    void draw_with(const DrawBatches<Other>& others, int vertices_each) const {
        for (std::size_t i = 0; i < buffers_.size(); ++i) {
            others.bind(i, 1);
            draw(i, vertices_each);
        }
    }
    void bind(std::size_t i, GLuint binding) const { buffers_[i].bind(binding); }

private:
    void draw(std::size_t i, int vertices_each) const {
        bind(i, 0);
        const std::size_t count = std::min(batch, total_ - i * batch);
        gl_.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(count) * vertices_each);
    }

    static constexpr std::size_t batch = 1u << 20;
    const gl::Functions& gl_;
    std::size_t total_;
    std::deque<gl::Buffer> buffers_;
};

// Rows [top, top + rows) of an image, and how the shaders of splat_shaders.h are told of them.
struct DrawnView {
    GLsizei width, height;
    GLsizei top, rows;
    float tan_x, tan_y;  // of half the field of view
    float near_depth, far_depth;

    DrawnView(const PixelGrid& grid, int top, int rows, double far_depth);
    // Makes the program current and sets what it shares with the others.
    void use(const gl::Functions& gl, const gl::Program& program) const;
};

// Throws ArgumentError, naming `size`, for what the device cannot draw, and DeviceError for one that lacks the means.
void check_drawable(const gl::Functions& gl, GLsizei width, GLsizei rows);

// The surface that each pixel sees: disks of surfels without triangles, and triangles.
struct SurfacePass {
    SurfacePass(const gl::Functions& gl, const DrawnView& view, const std::vector<DrawnDisk>& disks,
                const std::vector<FlatTriangle>& triangles);

    gl::Texture surface;  // RGBA32F: depth along the view axis, normal in the camera's frame
    gl::Texture seen;     // RG32I: surfel, -1 where nothing is, -2 - k for emitter k; and group, -1 but for surfels
    gl::Texture depth;    // linear, over the view's far depth
    gl::Framebuffer target;
};

// Those of the primitives with boxes that the rows may show.
template <class Primitive>
std::vector<Primitive> in_rows(const std::vector<Primitive>& all, int top, int rows) {
    std::vector<Primitive> out;
    for (const Primitive& one : all)
        if (one.box[1] < top + rows && one.box[3] > top) out.push_back(one);
    return out;
}

}  // namespace surflux
