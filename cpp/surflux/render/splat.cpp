#include "surflux/render/splat.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surflux/core/parallel.h"
#include "surflux/render/splat_shaders.h"
#include "surflux/render/surface_pass.h"

namespace surflux {

namespace {

// How far a kernel reaches along its normal, over how far in its plane: a neighbour on a curved surface lies off the
// plane by up to a tenth of it where the surfels sample the surface well, another sheet mostly farther.
constexpr float thickness = 0.45f;

// What the passes leave, per subpixel.
struct Raw {
    std::vector<float> sum;  // radiance times weight, and weight
    std::vector<float> depth;
    std::vector<std::int32_t> index;
};

Raw draw(const gl::Functions& gl, const DrawnGeometry& geometry, const std::vector<std::int32_t>& objects,
         double tan_half, GLsizei width, GLsizei height) {
    check_drawable(gl, width, height);
    const DrawnView view(width, height, tan_half, geometry.far_depth);
    GLuint vertex_array = 0;  // core GL draws nothing without one, though no attribute comes from it
    gl.GenVertexArrays(1, &vertex_array);
    gl.BindVertexArray(vertex_array);
    const DrawBatches<Splat> splats(gl, geometry.splats);
    const SurfacePass visibility(gl, view, geometry, splats);

    const gl::Texture sum(gl, GL_RGBA32F, width, height);
    const gl::Framebuffer blended(gl, {&sum});
    const gl::Buffer object_buffer(gl, objects);
    const gl::Program blend_program(gl, splat_shaders::blend_vertex, splat_shaders::blend_fragment);
    const float zero[4] = {0, 0, 0, 0};
    blended.bind();
    gl.ClearBufferfv(GL_COLOR, 0, zero);
    gl.Disable(GL_DEPTH_TEST);
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_ONE, GL_ONE);
    visibility.surface.bind(0);
    visibility.seen.bind(1);
    object_buffer.bind(1);
    view.use(gl, blend_program);
    gl.Uniform1f(blend_program.uniform("thickness"), thickness);
    splats.draw(6);

    Raw raw;
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    raw.sum.resize(4 * pixels);
    raw.depth.resize(pixels);
    raw.index.resize(pixels);
    blended.read(0, width, height, GL_RGBA, GL_FLOAT, raw.sum.data());
    visibility.target.read(0, width, height, GL_RED, GL_FLOAT, raw.depth.data());
    visibility.target.read(1, width, height, GL_RED_INTEGER, GL_INT, raw.index.data());
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

    const DrawnGeometry geometry = drawn_geometry(surfels, radiance, emitters, frame, options.footprint);
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
