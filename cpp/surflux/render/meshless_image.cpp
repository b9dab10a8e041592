#include "surflux/render/meshless_image.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/meshless/level_light.h"
#include "surflux/render/light_pixels.h"
#include "surflux/render/meshless_shaders.h"
#include "surflux/render/seen_places.h"
#include "surflux/render/seen_supports.h"
#include "surflux/render/seen_tiles.h"
#include "surflux/render/surface_pass.h"

namespace surflux {

namespace {

// What the passes leave.
struct Raw {
    std::vector<float> surface;      // depth, normal in the camera's frame
    std::vector<float> place;        // relative to the origin, and object
    std::vector<float> normal;       // in the camera's frame
    std::vector<std::int32_t> seen;  // surfel, group
    struct Light {
        LightPixels pixels;
        std::vector<float> all, direct;  // 4 for each of them
    };
    std::optional<Light> once;   // a pixel
    std::optional<Light> alone;  // of subpixels that have light of their own; none: they are few, and on the CPU
};

constexpr double few_alone = 0.03;  // of all that see a surface

// The point of the box around all surfaces in the camera's frame that is nearest to the eye.
Vec3 origin_of(const Surfels& surfels, const CameraFrame& frame) {
    if (surfels.size() == 0) return {};
    Vec3 low = frame.to_camera(surfels.positions[0]), high = low;
    for (const Vec3& position : surfels.positions) {
        const Vec3 p = frame.to_camera(position);
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], p[axis]);
            high[axis] = std::max(high[axis], p[axis]);
        }
    }
    Vec3 nearest;
    // A float's value, so that float32 and float64 know the same one.
    for (int axis = 0; axis < 3; ++axis) nearest[axis] = static_cast<float>(std::clamp(0.0, low[axis], high[axis]));
    return nearest;
}

struct Passes {
    const gl::Functions& gl;
    const MeshlessField& field;
    const DrawnFunctions& functions;
    const CameraFrame& frame;
    const DrawnView& view;
    const Vec3& origin;

    std::string text(const char* shader) const {
        return std::string(meshless_shaders::version) + (functions.direct ? meshless_shaders::direct_too : "") + shader;
    }
    gl::Program program(const char* vertex, const char* fragment) const {
        return {gl, text(vertex).c_str(), text(fragment).c_str()};
    }
    void use(const gl::Program& program) const {
        view.use(gl, program);
        gl.Uniform4f(program.uniform("origin"), static_cast<float>(origin.x), static_cast<float>(origin.y),
                     static_cast<float>(origin.z), 0.0f);
    }
    gl::Texture texture() const { return {gl, GL_RGBA32F, view.width, view.rows}; }
    // Where no direct light is told apart a single pixel stands for it, which nothing draws and nothing reads.
    gl::Texture direct_texture() const {
        return {gl, GL_RGBA32F, functions.direct ? view.width : 1, functions.direct ? view.rows : 1};
    }
    void clear(std::size_t attachments) const {
        const float zero[4] = {0, 0, 0, 0};
        for (std::size_t k = 0; k < attachments; ++k) gl.ClearBufferfv(GL_COLOR, static_cast<GLint>(k), zero);
    }
    void whole_image() const { gl.DrawArrays(GL_TRIANGLES, 0, 3); }

    // Light in the basis, and its direct part.
    struct Image {
        explicit Image(const Passes& passes)
            : all(passes.texture()), direct(passes.direct_texture()), target(passes.gl, colors(passes)) {
            target.bind();
            passes.clear(colors(passes).size());
        }
        std::vector<const gl::Texture*> colors(const Passes& passes) const {
            return passes.functions.direct ? std::vector{&all, &direct} : std::vector{&all};
        }
        gl::Texture all, direct;
        gl::Framebuffer target;
    };

    // Level by level, each from one image into the other. Returns the one that has all.
    const Image& add_levels(LightPixels& light, const std::array<Image, 2>& images) const {
        const SeenTiles tiles(light.places(), light.normals(), light.width(), light.height());
        const gl::Texture place = texture(), facing = texture(),
                          depth(gl, GL_DEPTH_COMPONENT32F, view.width, view.rows);
        place.write(light.width(), light.height(), GL_RGBA, GL_FLOAT, light.places().data());
        facing.write(light.width(), light.height(), GL_RGBA, GL_FLOAT, light.normals().data());
        std::vector<float> depths = light.depths();
        for (float& z : depths) z /= view.far_depth;
        depth.write(light.width(), light.height(), GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
        const gl::Texture sum = texture(), values = texture(), squares(gl, GL_R32F, view.width, view.rows);
        const gl::Texture direct_sum = direct_texture(), direct_values = direct_texture();
        std::vector<const gl::Texture*> colors{&sum, &values, &squares};
        if (functions.direct) colors.insert(colors.end(), {&direct_sum, &direct_values});
        const gl::Framebuffer sums(gl, colors, &depth);
        const gl::Program function_program =
            program(meshless_shaders::function_vertex, meshless_shaders::function_fragment);
        const gl::Program level_program = program(meshless_shaders::screen_vertex, meshless_shaders::level_fragment);
        std::vector<std::int32_t> coarsest = functions.coarsest;
        coarsest.resize(std::max<std::size_t>(coarsest.size(), 1), -1);
        const gl::Buffer coarsest_buffer(gl, coarsest);
        // The largest value, so that squares are floats.
        const auto use_unit = [&](const gl::Program& program) {
            const double unit = functions.largest > 0.0 ? 1.0 / functions.largest : 1.0;
            gl.Uniform1f(program.uniform("unit"), static_cast<float>(unit));
        };
        std::size_t done = 0;
        for (std::size_t level = 0; level < functions.levels.size(); ++level) {
            const std::vector<DrawnSupport> seen =
                seen_supports(field, functions.levels[level], frame, origin, view, tiles);
            if (seen.empty()) continue;
            light.divide_where_fine(seen, origin, view);
            const DrawBatches<DrawnSupport> batches(gl, seen);
            sums.bind();
            clear(colors.size());
            gl.Enable(GL_DEPTH_TEST);
            gl.Enable(GL_BLEND);
            gl.BlendFunc(GL_ONE, GL_ONE);
            place.bind(0);
            facing.bind(1);
            use(function_program);
            use_unit(function_program);
            batches.draw(6);

            const Image& before = images[done % 2];
            images[++done % 2].target.bind();
            gl.Disable(GL_DEPTH_TEST);
            gl.Disable(GL_BLEND);
            GLuint unit = 1;
            for (const gl::Texture* from :
                 {&sum, &values, &squares, &before.all, &direct_sum, &direct_values, &before.direct})
                from->bind(unit++);
            coarsest_buffer.bind(1);
            use(level_program);
            use_unit(level_program);
            gl.Uniform1f(level_program.uniform("level"), static_cast<float>(level));
            gl.Uniform4f(level_program.uniform("limits"), static_cast<float>(field.largest_deviation),
                         static_cast<float>(field.largest_part), 0.0f, 0.0f);
            whole_image();
        }
        return images[done % 2];
    }
};

Raw draw(const gl::Functions& gl, const MeshlessField& field, const DrawnFunctions& functions, const Scene& scene,
         const DrawnGeometry& geometry, const CameraFrame& frame, const Vec3& origin, const PixelGrid& grid, int top,
         int rows, int samples) {
    const DrawnView view(grid, top, rows, geometry.far_depth);
    check_drawable(gl, view.width, view.rows);
    Raw raw;
    const auto read = [](const gl::Framebuffer& from, GLuint attachment, int width, int height) {
        std::vector<float> out(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
        from.read(attachment, width, height, GL_RGBA, GL_FLOAT, out.data());
        return out;
    };
    {
        const Passes passes{gl, field, functions, frame, view, origin};
        const SurfacePass visibility(gl, view, geometry.disks, geometry.triangles);
        const gl::Texture place = passes.texture(), facing = passes.texture();
        const gl::Framebuffer seen(gl, {&place, &facing});
        std::vector<std::int32_t> objects(scene.object.begin(), scene.object.end());
        objects.resize(std::max<std::size_t>(objects.size(), 1), 0);
        const gl::Buffer object_buffer(gl, objects);
        const gl::Program place_program =
            passes.program(meshless_shaders::screen_vertex, meshless_shaders::place_fragment);
        seen.bind();
        gl.Disable(GL_DEPTH_TEST);
        visibility.surface.bind(0);
        visibility.seen.bind(1);
        object_buffer.bind(1);
        passes.use(place_program);
        passes.whole_image();
        raw.place = read(seen, 0, view.width, view.rows);
        raw.normal = read(seen, 1, view.width, view.rows);
        raw.surface = read(visibility.target, 0, view.width, view.rows);
        raw.seen.resize(raw.place.size() / 2);
        visibility.target.read(1, view.width, view.rows, GL_RG_INTEGER, GL_INT, raw.seen.data());
    }

    gl.DepthMask(GL_FALSE);
    const auto light_of = [&](LightPixels pixels) {
        const int side = view.width / pixels.width();
        const PixelGrid coarser{grid.width / side, grid.height / side, grid.tan_x, grid.tan_y};
        const DrawnView lit(coarser, top / side, rows / side, geometry.far_depth);
        const Passes passes{gl, field, functions, frame, lit, origin};
        gl.Viewport(0, 0, lit.width, lit.rows);
        const std::array<Passes::Image, 2> images{Passes::Image(passes), Passes::Image(passes)};
        const Passes::Image& image = passes.add_levels(pixels, images);
        Raw::Light light{std::move(pixels), read(image.target, 0, lit.width, lit.rows), {}};
        if (functions.direct) light.direct = read(image.target, 1, lit.width, lit.rows);
        return light;
    };
    const auto pixel = static_cast<float>(2.0 * grid.tan_y * samples / grid.height);
    raw.once = light_of({raw.place, raw.normal, raw.surface, view.width, view.rows, samples, pixel});
    LightPixels& pixels = raw.once->pixels;
    pixels.divide_where_uneven(raw.once->all);
    if (functions.direct) pixels.divide_where_uneven(raw.once->direct);
    if (pixels.share_alone() > few_alone) raw.alone = light_of(pixels.alone(raw.place, raw.normal, raw.surface));
    return raw;
}

Vec3 vec3_of(const float* from) {
    return {static_cast<double>(from[0]), static_cast<double>(from[1]), static_cast<double>(from[2])};
}

MeshlessImage resolve(const Raw& raw, const MeshlessField& field, const DrawnFunctions& functions,
                      const PartedSurfels* parted, const Scene& scene, const CameraFrame& frame, const Vec3& origin,
                      std::size_t width, std::size_t height) {
    const std::size_t pixels = width * height;
    MeshlessImage image;
    image.width = width;
    image.height = height;
    image.all.resize(3 * pixels);
    image.direct.resize(3 * pixels);
    image.depth.resize(pixels, std::numeric_limits<float>::infinity());
    image.normal.resize(3 * pixels);
    image.position.resize(pixels);
    image.index.resize(pixels);
    image.parted.resize(pixels, 0);
    image.hidden.resize(pixels, 0);
    const std::vector<std::uint32_t> triangles = triangle_ranges(scene.surfels);
    std::atomic<std::size_t> fallbacks{0};
    parallel_for(pixels, 4096, [&](std::size_t p) {
        const std::int32_t seen = image.index[p] = raw.seen[2 * p];
        if (seen == -1) return;
        image.depth[p] = raw.surface[4 * p];
        if (seen < 0) return;
        const auto surfel = static_cast<std::size_t>(seen);
        const Vec3 local = origin + vec3_of(&raw.place[4 * p]);
        image.position[p] =
            onto_patch(scene.surfels.triangles, triangles[surfel], triangles[surfel + 1],
                       frame.eye + local.x * frame.right + local.y * frame.down + local.z * frame.forward);
        const Vec3 turned = vec3_of(&raw.normal[4 * p]);
        const Vec3 normal = normalized(turned.x * frame.right + turned.y * frame.down + turned.z * frame.forward);
        store(&image.normal[3 * p], normal);
        const auto at = static_cast<std::uint32_t>(surfel);
        const std::uint32_t object = scene.object[surfel];
        const bool is_alone = raw.once->pixels.is_alone(p), is_patch = parted && parted->is_patch(at);
        const Raw::Light* light = !is_alone ? &*raw.once : raw.alone ? &*raw.alone : nullptr;
        const std::size_t lit = light ? 4 * light->pixels.pixel_of(p) : 0;
        const bool is_known = object < functions.coarsest.size() && functions.coarsest[object] >= 0;
        const bool is_uncovered = light && is_known && light->all[lit + 3] == 0.0f;
        image.parted[p] = parted && parted->is_parted(at);
        if (is_uncovered && !image.parted[p]) ++fallbacks;
        MeshlessField::At found;
        if (image.parted[p] || (is_patch && (!light || is_uncovered))) {
            image.hidden[p] = !parted->at(at, image.position[p], normal, found);  // the nearest may be behind a wall
        } else if (!light || is_uncovered) {
            if (is_known) found = field.at(image.position[p], normal, object);
        } else {
            found.all = vec3_of(&light->all[lit]);
            if (functions.direct) found.direct = vec3_of(&light->direct[lit]);
            found.clamp();
        }
        store(&image.all[3 * p], found.all);
        store(&image.direct[3 * p], found.direct);
    });
    image.fallbacks = fallbacks;
    return image;
}

}  // namespace

MeshlessImage meshless_image(const MeshlessField& field, const DrawnFunctions& functions, PartedSurfels* parted,
                             const Scene& scene, const std::vector<VisibleEmitter>& emitters, const Camera& camera,
                             std::size_t width, std::size_t height, int samples, const ImageRows& rows, bool culling,
                             gl::Api api) {
    require(width >= 1 && height >= 1 && width <= 65536 && height <= 65536,
            "size: wanted 1 to 65536 pixels a side, got ", width, " x ", height);
    const std::size_t count = rows.within(height);
    const auto side = static_cast<std::size_t>(samples);
    require(samples >= 1 && width % side == 0 && height % side == 0 && rows.first % side == 0 && count % side == 0,
            "samples: wanted one that sizes and rows are multiples of, got ", samples);
    require(scene.object.size() == scene.surfels.size(), "scene: wanted one object for each of ", scene.surfels.size(),
            " surfels, got ", scene.object.size());
    const CameraFrame frame = frame_of(camera);
    const Vec3 origin = origin_of(scene.surfels, frame);
    const PixelGrid grid{static_cast<int>(width), static_cast<int>(height),
                         frame.tan_half * static_cast<double>(width) / static_cast<double>(height), frame.tan_half};
    const std::vector<std::int32_t> objects(scene.object.begin(), scene.object.end());
    DrawingOptions drawing;
    drawing.kernels = false;
    drawing.culling = culling;
    const DrawnGeometry geometry = drawn_geometry(scene.surfels, objects, emitters, frame, grid, drawing);
    Raw raw;
    gl::run_pass(
        [&](const gl::Context& context) {
            raw = draw(context.gl, field, functions, scene, geometry, frame, origin, grid, static_cast<int>(rows.first),
                       static_cast<int>(count), samples);
        },
        api);
    if (parted) {
        std::vector<char> is_seen(scene.surfels.size(), 0);
        for (std::size_t p = 0; p < raw.seen.size(); p += 2)
            if (raw.seen[p] >= 0) is_seen[static_cast<std::size_t>(raw.seen[p])] = 1;
        std::vector<std::uint32_t> seen;
        for (std::uint32_t i = 0; i < is_seen.size(); ++i)
            if (is_seen[i]) seen.push_back(i);
        parted->find(std::move(seen));
    }
    return resolve(raw, field, functions, parted, scene, frame, origin, width, count);
}

}  // namespace surflux
