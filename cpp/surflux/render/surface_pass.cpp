#include "surflux/render/surface_pass.h"

#include <cmath>

#include "surflux/render/splat_shaders.h"

namespace surflux {

namespace {

// What surfels are drawn with: a disk that closes the surface, and a kernel that blends it smoothly.
struct Reach {
    double disk, kernel;
};

// Disks that reach far stick out of silhouettes and creases; where areas are known, 1.4 sqrt(S) closes the surface as
// well as R does: on random points of a sphere neither leaves a hole. Kernels of that size are smooth, where those of
// estimated radii, which just close the surface, show every surfel. A patch's own radius reaches its farthest corner,
// which in a square is nearer than the next centre: there the kernel needs the spacing of the patches, sqrt(S).
std::vector<Reach> reaches(const Surfels& surfels) {
    std::vector<double> patch(surfels.size(), 0.0);
    for (const Triangle& t : surfels.triangles) patch[t.surfel] += area_of(t);
    std::vector<Reach> out;
    for (std::size_t i = 0; i < surfels.size(); ++i) {
        const double radius = surfels.radii[i];
        out.push_back({radius, radius});
        if (patch[i] > 0.0) {
            out[i].kernel = std::max(radius, std::sqrt(patch[i]));
        } else if (!surfels.areas.empty()) {
            const double even = 1.4 * std::sqrt(surfels.areas[i]);
            out[i] = {std::min(radius, even), std::min(2.0 * radius, even)};
        }
    }
    return out;
}

void add_splats(DrawnGeometry& geometry, const Surfels& surfels, const std::vector<Rgb>& radiance,
                const CameraFrame& frame, double footprint) {
    const std::vector<std::uint32_t> begin = triangle_ranges(surfels);
    const std::vector<Reach> reach = reaches(surfels);
    for (std::size_t i = 0; i < surfels.size(); ++i) {
        const Vec3 center = frame.to_camera(surfels.positions[i]);
        const Vec3 normal = frame.turn(surfels.normals[i]);
        const double kernel = footprint * reach[i].kernel;
        if (!(kernel > 0.0) || center.z + kernel <= 0.0) continue;
        // Turned away so far that no front-facing surface agrees with its normal (see blend_fragment).
        const double distance = length(center);
        if (distance > 10.0 * kernel && dot(normal, center) > 0.9 * distance) continue;
        Splat& splat = geometry.splats.emplace_back();
        store(splat.center, center);
        store(splat.normal, normal);
        store(splat.radiance, radiance[i]);
        splat.kernel = static_cast<float>(kernel);
        splat.disk = begin[i] == begin[i + 1] ? static_cast<float>(reach[i].disk) : 0.0f;
        splat.index = static_cast<std::int32_t>(i);
        geometry.far_depth = std::max(geometry.far_depth, center.z + kernel);
    }
}

void add_triangle(DrawnGeometry& geometry, const CameraFrame& frame, const Triangle& world, const Vec3& normal,
                  int index) {
    const Triangle t{frame.to_camera(world.a), frame.to_camera(world.b), frame.to_camera(world.c), 0};
    const double farthest = std::max({t.a.z, t.b.z, t.c.z});
    if (farthest <= 0.0 || dot(cross_of(t), t.a) >= 0.0) return;
    FlatTriangle& flat = geometry.triangles.emplace_back();
    store(flat.corners[0], t.a);
    store(flat.corners[1], t.b);
    store(flat.corners[2], t.c);
    store(flat.normal, frame.turn(normal));
    flat.index = index;
    geometry.far_depth = std::max(geometry.far_depth, farthest);
}

void add_emitter(DrawnGeometry& geometry, const CameraFrame& frame, const VisibleEmitter& e, int index) {
    const Vec3 opposite = e.corner + e.u + e.v;
    add_triangle(geometry, frame, {e.corner, e.corner + e.u, opposite, 0}, {}, index);
    add_triangle(geometry, frame, {e.corner, opposite, e.corner + e.v, 0}, {}, index);
}

}  // namespace

DrawnGeometry drawn_geometry(const Surfels& surfels, const std::vector<Rgb>& radiance,
                             const std::vector<VisibleEmitter>& emitters, const CameraFrame& frame, double footprint) {
    DrawnGeometry geometry;
    add_splats(geometry, surfels, radiance, frame, footprint);
    for (const Triangle& t : surfels.triangles) {
        add_triangle(geometry, frame, t, surfels.normals[t.surfel], static_cast<std::int32_t>(t.surfel));
    }
    for (std::size_t k = 0; k < emitters.size(); ++k) {
        const VisibleEmitter& e = emitters[k];
        require(is_finite(e.corner) && is_finite(e.u) && is_finite(e.v) && is_finite(e.radiance), "emitters: number ",
                k, " is not finite");
        require(length(cross(e.u, e.v)) > 0.0, "emitters: the edges of number ", k, " span no area");
        add_emitter(geometry, frame, e, -2 - static_cast<std::int32_t>(k));
    }
    return geometry;
}

void check_drawable(const gl::Functions& gl, GLsizei width, GLsizei height) {
    GLint largest = 0, viewport[2] = {0, 0};
    gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    gl.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
    require(width <= std::min(largest, viewport[0]) && height <= std::min(largest, viewport[1]), "size: this GL device",
            " draws at most ", std::min({largest, viewport[0], viewport[1]}), " pixels a side, subpixels counted, got ",
            width, " x ", height);
    gl::require_storage_buffers(gl);
}

DrawnView::DrawnView(GLsizei width_, GLsizei height_, double tan_half, double farthest)
    : width(width_),
      height(height_),
      tan_x(static_cast<float>(tan_half) * static_cast<float>(width_) / static_cast<float>(height_)),
      tan_y(static_cast<float>(tan_half)),
      near_depth(1e-6f * static_cast<float>(1.001 * farthest)),
      far_depth(static_cast<float>(1.001 * farthest)) {}

void DrawnView::use(const gl::Functions& gl, const gl::Program& program) const {
    program.use();
    gl.Uniform2f(program.uniform("scale"), 1.0f / tan_x, 1.0f / tan_y);
    gl.Uniform1f(program.uniform("near_depth"), near_depth);
    gl.Uniform1f(program.uniform("far_depth"), far_depth);
    gl.Uniform4f(program.uniform("ray"), 2.0f * tan_x / static_cast<float>(width),
                 2.0f * tan_y / static_cast<float>(height), -tan_x, -tan_y);
}

SurfacePass::SurfacePass(const gl::Functions& gl, const DrawnView& view, const DrawnGeometry& geometry,
                         const DrawBatches<Splat>& splats)
    : surface(gl, GL_RGBA32F, view.width, view.height),
      seen(gl, GL_R32I, view.width, view.height),
      depth(gl, GL_DEPTH_COMPONENT32F, view.width, view.height),
      target(gl, {&surface, &seen}, &depth) {
    const DrawBatches<FlatTriangle> triangles(gl, geometry.triangles);
    const gl::Program triangle_program(gl, splat_shaders::triangle_vertex, splat_shaders::surface_fragment);
    const gl::Program disk_program(gl, splat_shaders::disk_vertex, splat_shaders::surface_fragment);
    const float zero[4] = {0, 0, 0, 0}, one = 1.0f;
    const GLint nothing[4] = {-1, -1, -1, -1};
    target.bind();
    gl.Viewport(0, 0, view.width, view.height);
    gl.ClearBufferfv(GL_COLOR, 0, zero);
    gl.ClearBufferiv(GL_COLOR, 1, nothing);
    gl.ClearBufferfv(GL_DEPTH, 0, &one);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LESS);
    view.use(gl, triangle_program);
    triangles.draw(3);
    view.use(gl, disk_program);
    splats.draw(6);
}

}  // namespace surflux
