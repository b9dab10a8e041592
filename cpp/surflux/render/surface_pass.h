#pragma once

// What the passes of this room share: primitives in buffers, the view, and the pass that finds the surface that each
// pixel sees.

#include <algorithm>
#include <array>
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

    // As points where each has one vertex, else as triangles.
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
        gl_.DrawArrays(vertices_each == 1 ? GL_POINTS : GL_TRIANGLES, 0, static_cast<GLsizei>(count) * vertices_each);
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
    float tan_x, tan_y;  // as of PixelGrid
    bool parallel;
    float near_depth, far_depth;

    DrawnView(const PixelGrid& grid, int top, int rows, double far_depth);
    // Makes the program current and sets what it shares with the others. corners: vertices of each primitive that has a
    // box.
    void use(const gl::Functions& gl, const gl::Program& program, int corners = 6) const;
};

// Pixels of a side of a box that is drawn as a point.
int largest_point(const gl::Functions& gl);

// Throws ArgumentError, naming `size`, for what the device cannot draw, and DeviceError for one that lacks the means.
void check_drawable(const gl::Functions& gl, GLsizei width, GLsizei rows);

// Primitives with boxes, by how a view shows them: small boxes as points, which are squares of one vertex - llvmpipe
// spends most of its time on vertices -, larger ones as two triangles.
template <class Primitive>
struct InView {
    static constexpr std::array<int, 2> corners{1, 6};
    std::array<std::vector<Primitive>, 2> parts;

    InView(const gl::Functions& gl, const DrawnView& view, const std::vector<Primitive>& all) {
        const int most = std::min({largest_point(gl), static_cast<int>(view.width), static_cast<int>(view.rows)});
        for (const Primitive& one : all) {
            const std::int32_t (&box)[4] = one.box;
            if (box[1] >= view.top + view.rows || box[3] <= view.top) continue;
            parts[box[2] - box[0] <= most && box[3] - box[1] <= most ? 0 : 1].push_back(one);
        }
    }
};

// The surface that each pixel sees: disks of surfels without triangles, and triangles.
struct SurfacePass {
    SurfacePass(const gl::Functions& gl, const DrawnView& view, const std::vector<DrawnDisk>& disks,
                const std::vector<FlatTriangle>& triangles);

    gl::Texture surface;  // RGBA32F: depth along the view axis, normal in the camera's frame
    gl::Texture seen;     // RG32I: surfel, -1 where nothing is, -2 - k for emitter k; and group, -1 but for surfels
    gl::Texture depth;    // linear, over the view's far depth
    gl::Framebuffer target;
};

}  // namespace surflux
