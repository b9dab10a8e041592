#include "surflux/render/splat.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <deque>
#include <limits>

#include "surflux/core/parallel.h"
#include "surflux/gl/objects.h"
#include "surflux/render/splat_shaders.h"

namespace surflux {

namespace {

// How far a kernel reaches along its normal, over how far in its plane: a neighbour on a curved surface lies off the
// plane by up to a tenth of it where the surfels sample the surface well, another sheet mostly farther.
constexpr float thickness = 0.45f;

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

struct Geometry {
    std::vector<Splat> splats;
    std::vector<FlatTriangle> triangles;
    double far_depth = 0.0;
};

void store(float* to, const Vec3& from) {
    for (int axis = 0; axis < 3; ++axis) to[axis] = static_cast<float>(from[axis]);
}

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

void add_splats(Geometry& geometry, const Surfels& surfels, const std::vector<Rgb>& radiance, const CameraFrame& frame,
                double footprint) {
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

void add_triangle(Geometry& geometry, const CameraFrame& frame, const Triangle& world, const Vec3& normal, int index) {
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

void add_emitter(Geometry& geometry, const CameraFrame& frame, const VisibleEmitter& e, int index) {
    const Vec3 opposite = e.corner + e.u + e.v;
    add_triangle(geometry, frame, {e.corner, e.corner + e.u, opposite, 0}, {}, index);
    add_triangle(geometry, frame, {e.corner, opposite, e.corner + e.v, 0}, {}, index);
}

// Primitives in buffers of a size that every driver takes in one block (128 MiB is promised).
template <class Primitive>
class Batches {
public:
    Batches(const gl::Functions& gl, const std::vector<Primitive>& primitives) : gl_(gl), total_(primitives.size()) {
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

// What the passes leave, per subpixel.
struct Raw {
    std::vector<float> sum;  // radiance times weight, and weight
    std::vector<float> depth;
    std::vector<std::int32_t> index;
};

void check_size(const gl::Functions& gl, GLsizei width, GLsizei height) {
    GLint largest = 0, viewport[2] = {0, 0}, blocks = 0;
    gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    gl.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
    require(width <= std::min(largest, viewport[0]) && height <= std::min(largest, viewport[1]), "size: this GL device",
            " draws at most ", std::min({largest, viewport[0], viewport[1]}), " pixels a side, subpixels counted, got ",
            width, " x ", height);
    for (GLenum stage : {GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS, GL_MAX_FRAGMENT_SHADER_STORAGE_BLOCKS}) {
        gl.GetIntegerv(stage, &blocks);
        if (blocks < 2) throw DeviceError("the driver has no storage buffers in vertex and fragment shaders");
    }
}

Raw draw(const gl::Functions& gl, const Geometry& geometry, const std::vector<std::int32_t>& objects, double tan_half,
         GLsizei width, GLsizei height) {
    check_size(gl, width, height);
    const auto far_depth = static_cast<float>(1.001 * geometry.far_depth);
    const float near_depth = 1e-6f * far_depth;
    const auto tan_y = static_cast<float>(tan_half);
    const float tan_x = tan_y * static_cast<float>(width) / static_cast<float>(height);

    const gl::Texture surface(gl, GL_RGBA32F, width, height), seen(gl, GL_R32I, width, height);
    const gl::Texture depth(gl, GL_DEPTH_COMPONENT32F, width, height), sum(gl, GL_RGBA32F, width, height);
    const gl::Framebuffer visibility(gl, {&surface, &seen}, &depth), blended(gl, {&sum});
    const Batches<Splat> splats(gl, geometry.splats);
    const Batches<FlatTriangle> triangles(gl, geometry.triangles);
    const gl::Buffer object_buffer(gl, objects);
    const gl::Program triangle_program(gl, splat_shaders::triangle_vertex, splat_shaders::surface_fragment);
    const gl::Program disk_program(gl, splat_shaders::disk_vertex, splat_shaders::surface_fragment);
    const gl::Program blend_program(gl, splat_shaders::blend_vertex, splat_shaders::blend_fragment);
    GLuint vertex_array = 0;  // core GL draws nothing without one, though no attribute comes from it
    gl.GenVertexArrays(1, &vertex_array);
    gl.BindVertexArray(vertex_array);
    gl.Viewport(0, 0, width, height);
    const auto use = [&](const gl::Program& program) {
        program.use();
        gl.Uniform2f(program.uniform("scale"), 1.0f / tan_x, 1.0f / tan_y);
        gl.Uniform1f(program.uniform("near_depth"), near_depth);
        gl.Uniform1f(program.uniform("far_depth"), far_depth);
        gl.Uniform1f(program.uniform("thickness"), thickness);
        gl.Uniform4f(program.uniform("ray"), 2.0f * tan_x / static_cast<float>(width),
                     2.0f * tan_y / static_cast<float>(height), -tan_x, -tan_y);
    };

    const float zero[4] = {0, 0, 0, 0}, one = 1.0f;
    const GLint nothing[4] = {-1, -1, -1, -1};
    visibility.bind();
    gl.ClearBufferfv(GL_COLOR, 0, zero);
    gl.ClearBufferiv(GL_COLOR, 1, nothing);
    gl.ClearBufferfv(GL_DEPTH, 0, &one);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LESS);
    use(triangle_program);
    triangles.draw(3);
    use(disk_program);
    splats.draw(6);

    blended.bind();
    gl.ClearBufferfv(GL_COLOR, 0, zero);
    gl.Disable(GL_DEPTH_TEST);
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_ONE, GL_ONE);
    surface.bind(0);
    seen.bind(1);
    object_buffer.bind(1);
    use(blend_program);
    splats.draw(6);

    Raw raw;
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    raw.sum.resize(4 * pixels);
    raw.depth.resize(pixels);
    raw.index.resize(pixels);
    blended.read(0, width, height, GL_RGBA, GL_FLOAT, raw.sum.data());
    visibility.read(0, width, height, GL_RED, GL_FLOAT, raw.depth.data());
    visibility.read(1, width, height, GL_RED_INTEGER, GL_INT, raw.index.data());
    return raw;
}

// Normalizes every subpixel and averages those of a pixel.
SplatImage resolve(const Raw& raw, const Surfels& surfels, const std::vector<Rgb>& radiance,
                   const std::vector<VisibleEmitter>& emitters, std::size_t width, std::size_t height,
                   const SplatOptions& options) {
    const auto samples = static_cast<std::size_t>(options.samples);
    const auto color_of = [&](std::size_t at) -> Rgb {
        const std::int32_t index = raw.index[at];
        if (index == -1) return options.background;
        if (index < -1) return emitters[static_cast<std::size_t>(-2 - index)].radiance;
        const float* sum = &raw.sum[4 * at];
        // No kernel reaches this point (a large triangle of a patch far from its surfel): its surfel's own colour.
        if (!(sum[3] > 0.0f)) return radiance[static_cast<std::size_t>(index)];
        return Rgb{sum[0], sum[1], sum[2]} / static_cast<double>(sum[3]);
    };
    const std::size_t pixels = width * height;
    SplatImage image{width, height, {}, {}, {}, {}, {}};
    image.radiance.resize(3 * pixels);
    image.coverage.resize(pixels);
    image.depth.resize(pixels, std::numeric_limits<float>::infinity());
    image.normal.resize(3 * pixels);
    image.index.resize(pixels, -1);
    parallel_for(height, 8, [&](std::size_t y) {
        for (std::size_t x = 0; x < width; ++x) {
            const std::size_t pixel = y * width + x;
            const auto at = [&](std::size_t i, std::size_t j) {
                return (y * samples + j) * width * samples + x * samples + i;
            };
            Rgb color;
            std::size_t covered = 0;
            for (std::size_t j = 0; j < samples; ++j) {
                for (std::size_t i = 0; i < samples; ++i) {
                    color += color_of(at(i, j));
                    covered += raw.index[at(i, j)] != -1;
                }
            }
            const auto count = static_cast<double>(samples * samples);
            store(&image.radiance[3 * pixel], color / count);
            image.coverage[pixel] = static_cast<float>(static_cast<double>(covered) / count);
            const std::size_t middle = at(samples / 2, samples / 2);
            const std::int32_t index = raw.index[middle];
            image.index[pixel] = index;
            if (index == -1) continue;
            image.depth[pixel] = raw.depth[middle];
            if (index >= 0) {
                store(&image.normal[3 * pixel], surfels.normals[static_cast<std::size_t>(index)]);
            } else {
                const VisibleEmitter& e = emitters[static_cast<std::size_t>(-2 - index)];
                store(&image.normal[3 * pixel], normalized(cross(e.u, e.v)));
            }
        }
    });
    return image;
}

}  // namespace

SplatImage splat_image(const Surfels& surfels, const std::vector<Rgb>& radiance,
                       const std::vector<VisibleEmitter>& emitters, const Camera& camera, std::size_t width,
                       std::size_t height, const SplatOptions& options, gl::Api api) {
    require(radiance.size() == surfels.size(), "radiance: wanted one RGB value for each of ", surfels.size(),
            " surfels, got ", radiance.size());
    require(std::all_of(radiance.begin(), radiance.end(), is_finite), "radiance: wanted finite numbers");
    require(is_finite(options.background), "background: wanted finite numbers");
    require(width >= 1 && height >= 1 && width <= 65536 && height <= 65536,
            "size: wanted 1 to 65536 pixels a side, got ", width, " x ", height);
    require(options.footprint >= 1.0 && options.footprint <= 10.0, "footprint: wanted 1 to 10, got ",
            options.footprint);
    require(options.samples >= 1 && options.samples <= 16, "samples: wanted 1 to 16, got ", options.samples);
    require(options.objects.empty() || options.objects.size() == surfels.size(), "objects: wanted one for each of ",
            surfels.size(), " surfels, got ", options.objects.size());
    const CameraFrame frame = frame_of(camera);
    std::vector<std::int32_t> objects = options.objects;
    objects.resize(std::max<std::size_t>(surfels.size(), 1), 0);

    Geometry geometry;
    add_splats(geometry, surfels, radiance, frame, options.footprint);
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
    Raw raw;
    gl::run_pass(
        [&](const gl::Context& context) {
            raw = draw(context.gl, geometry, objects, frame.tan_half, static_cast<GLsizei>(width) * options.samples,
                       static_cast<GLsizei>(height) * options.samples);
        },
        api);
    return resolve(raw, surfels, radiance, emitters, width, height, options);
}

}  // namespace surflux
