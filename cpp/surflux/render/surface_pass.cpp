#include "surflux/render/surface_pass.h"

#include <string>

#include "surflux/render/splat_shaders.h"

namespace surflux {

void check_drawable(const gl::Functions& gl, GLsizei width, GLsizei rows) {
    GLint largest = 0, viewport[2] = {0, 0};
    gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    gl.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
    require(width <= std::min(largest, viewport[0]) && rows <= std::min(largest, viewport[1]), "size: this GL device",
            " draws at most ", std::min({largest, viewport[0], viewport[1]}), " pixels a row, subpixels counted, got ",
            width);
    gl::require_storage_buffers(gl);
}

DrawnView::DrawnView(const PixelGrid& grid, int top_, int rows_, double farthest)
    : width(grid.width),
      height(grid.height),
      top(top_),
      rows(rows_),
      tan_x(static_cast<float>(grid.tan_x)),
      tan_y(static_cast<float>(grid.tan_y)),
      parallel(grid.parallel),
      near_depth(1e-6f * static_cast<float>(1.001 * farthest)),
      far_depth(static_cast<float>(1.001 * farthest)) {}

int largest_point(const gl::Functions& gl) {
    // Where boxes are long and thin, squares would be mostly empty.
    constexpr int most = 16;
    GLint sizes[2] = {1, 1};
    gl.GetIntegerv(GL_POINT_SIZE_RANGE, sizes);
    return std::min(most, sizes[1]);
}

void DrawnView::use(const gl::Functions& gl, const gl::Program& program, int corners) const {
    const auto all = static_cast<float>(height), first = static_cast<float>(top), part = static_cast<float>(rows);
    const float pixel_x = 2.0f * tan_x / static_cast<float>(width), pixel_y = 2.0f * tan_y / all;
    program.use();
    gl.Uniform4f(program.uniform("scale"), 1.0f / tan_x, all / part / tan_y, (all - 2.0f * first) / part - 1.0f, 0.0f);
    gl.Uniform4f(program.uniform("band"), static_cast<float>(width), part, first, static_cast<float>(corners));
    gl.Uniform1f(program.uniform("near_depth"), near_depth);
    gl.Uniform1f(program.uniform("far_depth"), far_depth);
    gl.Uniform1f(program.uniform("parallel"), parallel ? 1.0f : 0.0f);
    gl.Uniform4f(program.uniform("ray"), pixel_x, pixel_y, -tan_x, first * pixel_y - tan_y);
}

SurfacePass::SurfacePass(const gl::Functions& gl, const DrawnView& view, const std::vector<DrawnDisk>& disks,
                         const std::vector<FlatTriangle>& triangles)
    : surface(gl, GL_RGBA32F, view.width, view.rows),
      seen(gl, GL_RG32I, view.width, view.rows),
      depth(gl, GL_DEPTH_COMPONENT32F, view.width, view.rows),
      target(gl, {&surface, &seen}, &depth) {
    const DrawBatches<FlatTriangle> triangle_batches(gl, triangles);
    const InView<DrawnDisk> shown(gl, view, disks);
    const gl::Program triangle_program(gl, splat_shaders::triangle_vertex, splat_shaders::triangle_fragment);
    const gl::Program disk_program(gl, (std::string(splat_shaders::box) + splat_shaders::disk_vertex).c_str(),
                                   splat_shaders::disk_fragment);
    const float zero[4] = {0, 0, 0, 0}, one = 1.0f;
    const GLint nothing[4] = {-1, -1, -1, -1};
    target.bind();
    gl.Viewport(0, 0, view.width, view.rows);
    gl.ClearBufferfv(GL_COLOR, 0, zero);
    gl.ClearBufferiv(GL_COLOR, 1, nothing);
    gl.ClearBufferfv(GL_DEPTH, 0, &one);
    gl.Disable(GL_BLEND);
    gl.DepthMask(GL_TRUE);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LESS);
    view.use(gl, triangle_program);
    triangle_batches.draw(3);
    gl.Enable(GL_PROGRAM_POINT_SIZE);
    for (std::size_t k = 0; k < shown.parts.size(); ++k) {
        view.use(gl, disk_program, shown.corners[k]);
        DrawBatches<DrawnDisk>(gl, shown.parts[k]).draw(shown.corners[k]);
    }
}

}  // namespace surflux
