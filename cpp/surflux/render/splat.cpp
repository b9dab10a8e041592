#include "surflux/render/splat.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <functional>
#include <limits>
#include <mutex>
#include <string>
#include <thread>

#include "surflux/core/parallel.h"
#include "surflux/render/splat_shaders.h"
#include "surflux/render/surface_pass.h"

namespace surflux {

namespace {

constexpr std::size_t subpixels_at_once = 1u << 20;  // of a band: 80 MB with four layers
constexpr std::size_t layers_at_once = 4;            // every device draws into eight

// What the passes leave of a band, per subpixel.
struct Raw {
    std::vector<std::vector<float>> sums;  // of each layer: value times weight, and weight
    std::vector<float> surface;            // depth, normal in the camera's frame
    std::vector<std::int32_t> seen;        // surfel, group
};

class Painter {
public:
    Painter(const gl::Functions& gl, const DrawnGeometry& geometry, const std::vector<SplatLayer>& layers,
            const PixelGrid& grid)
        : gl_(gl), geometry_(geometry), layers_(layers), grid_(grid), walls_(gl, geometry.walls) {}

    // Rows [top, top + rows) of subpixels.
    Raw draw(int top, int rows) const {
        const DrawnView view(grid_, top, rows, geometry_.far_depth);
        const SurfacePass visibility(gl_, view, geometry_.disks, geometry_.triangles);
        Raw raw;
        const std::size_t pixels = static_cast<std::size_t>(grid_.width) * static_cast<std::size_t>(rows);
        raw.surface.resize(4 * pixels);
        raw.seen.resize(2 * pixels);
        visibility.target.read(0, grid_.width, rows, GL_RGBA, GL_FLOAT, raw.surface.data());
        visibility.target.read(1, grid_.width, rows, GL_RG_INTEGER, GL_INT, raw.seen.data());
        const InView<DrawnKernel> kernels(gl_, view, geometry_.kernels);
        gl_.Disable(GL_DEPTH_TEST);
        gl_.Enable(GL_BLEND);
        gl_.BlendFunc(GL_ONE, GL_ONE);
        for (std::size_t first = 0; first < layers_.size(); first += layers_at_once)
            blend(view, visibility, kernels, first, std::min(layers_at_once, layers_.size() - first), raw);
        return raw;
    }

private:
    void blend(const DrawnView& view, const SurfacePass& visibility, const InView<DrawnKernel>& kernels,
               std::size_t first, std::size_t count, Raw& raw) const {
        std::deque<gl::Texture> textures;
        std::vector<const gl::Texture*> targets;
        for (std::size_t layer = 0; layer < count; ++layer)
            targets.push_back(&textures.emplace_back(gl_, GL_RGBA32F, view.width, view.rows));
        const gl::Framebuffer blended(gl_, targets);
        const std::string defined = message("#define LAYERS ", count, "\n");
        const gl::Program program(gl_, (splat_shaders::box + defined + splat_shaders::kernel_vertex).c_str(),
                                  ("#version 430\n" + defined + splat_shaders::kernel_fragment).c_str());
        const float zero[4] = {0, 0, 0, 0};
        blended.bind();
        walls_.bind(2);
        for (std::size_t layer = 0; layer < count; ++layer)
            gl_.ClearBufferfv(GL_COLOR, static_cast<GLint>(layer), zero);
        visibility.surface.bind(0);
        visibility.seen.bind(1);
        for (std::size_t k = 0; k < kernels.parts.size(); ++k) {
            const std::vector<DrawnKernel>& part = kernels.parts[k];
            const DrawBatches<DrawnKernel> batches(gl_, part);
            const DrawBatches<std::array<float, 4>> values(gl_, values_of(part, first, count), count);
            view.use(gl_, program, kernels.corners[k]);
            batches.draw_with(values, kernels.corners[k]);
        }
        for (std::size_t layer = 0; layer < count; ++layer) {
            std::vector<float>& sum = raw.sums.emplace_back(raw.surface.size());
            blended.read(static_cast<GLuint>(layer), view.width, view.rows, GL_RGBA, GL_FLOAT, sum.data());
        }
    }

    // Of each kernel, `count` layers from `first` on.
    std::vector<std::array<float, 4>> values_of(const std::vector<DrawnKernel>& kernels, std::size_t first,
                                                std::size_t count) const {
        std::vector<std::array<float, 4>> values(kernels.size() * count);
        parallel_for(kernels.size(), 8192, [&](std::size_t k) {
            for (std::size_t layer = 0; layer < count; ++layer) {
                store(values[k * count + layer].data(),
                      layers_[first + layer].values[static_cast<std::size_t>(kernels[k].index)]);
            }
        });
        return values;
    }

    const gl::Functions& gl_;
    const DrawnGeometry& geometry_;
    const std::vector<SplatLayer>& layers_;
    const PixelGrid& grid_;
    const gl::Buffer walls_;  // of all kernels
};

// Normalizes every subpixel and averages those of a pixel.
struct Resolver {
    const Surfels& surfels;
    const std::vector<SplatLayer>& layers;
    const std::vector<VisibleEmitter>& emitters;
    const CameraFrame& frame;
    std::size_t samples;

    Rgb color_of(const Raw& raw, std::size_t layer, std::size_t at) const {
        const std::int32_t index = raw.seen[2 * at];
        if (index == -1) return {};
        if (index < -1)
            return layers[layer].emitters_lit ? emitters[static_cast<std::size_t>(-2 - index)].radiance : Rgb();
        const float* sum = &raw.sums[layer][4 * at];
        // No kernel reaches this point (a large triangle of a patch far from its surfel): its surfel's own colour.
        if (!(sum[3] > 0.0f)) return layers[layer].values[static_cast<std::size_t>(index)];
        return Rgb{sum[0], sum[1], sum[2]} / static_cast<double>(sum[3]);
    }

    // Row y of the image, which is row `y - first` of the band.
    void row(const Raw& raw, std::size_t first, std::size_t y, SplatImage& image) const {
        const std::size_t width = image.width;
        const auto count = static_cast<double>(samples * samples);
        for (std::size_t x = 0; x < width; ++x) {
            const std::size_t pixel = y * width + x;
            const auto at = [&](std::size_t i, std::size_t j) {
                return ((y - first) * samples + j) * width * samples + x * samples + i;
            };
            std::size_t covered = 0;
            for (std::size_t j = 0; j < samples; ++j)
                for (std::size_t i = 0; i < samples; ++i) covered += raw.seen[2 * at(i, j)] != -1;
            image.coverage[pixel] = static_cast<float>(static_cast<double>(covered) / count);
            for (std::size_t layer = 0; layer < layers.size(); ++layer) {
                Rgb color;
                for (std::size_t j = 0; j < samples; ++j)
                    for (std::size_t i = 0; i < samples; ++i) color += color_of(raw, layer, at(i, j));
                store(&image.layers[layer][3 * pixel], color / count);
            }
            const std::size_t middle = at(samples / 2, samples / 2);
            image.index[pixel] = raw.seen[2 * middle];
            if (image.index[pixel] == -1) continue;
            const float* seen = &raw.surface[4 * middle];
            image.depth[pixel] = seen[0];
            const Vec3 normal = static_cast<double>(seen[1]) * frame.right + static_cast<double>(seen[2]) * frame.down +
                                static_cast<double>(seen[3]) * frame.forward;
            store(&image.normal[3 * pixel], normalized(normal));
        }
    }
};

// Work on a thread of OpenGL's, and the thread that asked for it: that one reports progress, as all passes do, and so
// hears of Ctrl-C.
class Steps {
public:
    // On the working thread, before each step: so many are done. False: stop.
    bool go_on(std::size_t done) {
        const std::lock_guard lock(mutex_);
        done_ = done;
        changed_.notify_one();
        return !cancelled_;
    }

    // Runs the work to its end, reporting how much of `total` is done; what either throws, this throws.
    void watch(const std::function<void()>& work, const Progress& progress, std::size_t total) {
        std::exception_ptr failure;
        std::thread thread(with_this_limit([&] {
            try {
                work();
            } catch (...) {
                failure = std::current_exception();
            }
            const std::lock_guard lock(mutex_);
            finished_ = true;
            changed_.notify_one();
        }));
        try {
            std::unique_lock lock(mutex_);
            while (!finished_) {
                const std::size_t done = done_;
                lock.unlock();
                report(progress, done, total);
                lock.lock();
                changed_.wait_for(lock, std::chrono::milliseconds(100), [&] { return finished_ || done_ != done; });
            }
        } catch (...) {
            {
                const std::lock_guard lock(mutex_);
                cancelled_ = true;
            }
            thread.join();
            throw;
        }
        thread.join();
        if (failure) std::rethrow_exception(failure);
        report(progress, total, total);
    }

private:
    std::mutex mutex_;
    std::condition_variable changed_;
    std::size_t done_ = 0;
    bool finished_ = false, cancelled_ = false;
};

void check(const Surfels& surfels, const std::vector<SplatLayer>& layers) {
    for (const SplatLayer& layer : layers) {
        require(layer.values.size() == surfels.size(), "values: wanted one RGB value for each of ", surfels.size(),
                " surfels, got ", layer.values.size());
        require(std::all_of(layer.values.begin(), layer.values.end(), is_finite), "values: wanted finite numbers");
    }
}

}  // namespace

void check_splats(const Surfels& surfels, std::size_t width, std::size_t height, const SplatOptions& options) {
    require(width >= 1 && height >= 1 && width <= 65536 && height <= 65536,
            "size: wanted 1 to 65536 pixels a side, got ", width, " x ", height);
    require(options.footprint >= 1.0 && options.footprint <= 10.0, "footprint: wanted 1 to 10, got ",
            options.footprint);
    require(options.samples >= 1 && options.samples <= 16, "samples: wanted 1 to 16, got ", options.samples);
    require(!options.walls || options.walls->surfels() == surfels.size(), "walls: wanted those of ", surfels.size(),
            " surfels");
    require(options.objects.empty() || options.objects.size() == surfels.size(), "objects: wanted one for each of ",
            surfels.size(), " surfels, got ", options.objects.size());
}

SplatImage splat_image(const Surfels& surfels, const std::vector<SplatLayer>& layers,
                       const std::vector<VisibleEmitter>& emitters, const Camera& camera, std::size_t width,
                       std::size_t height, const SplatOptions& options, const Progress& progress, gl::Api api) {
    check(surfels, layers);
    check_splats(surfels, width, height, options);
    const CameraFrame frame = frame_of(camera);
    std::vector<std::int32_t> objects = options.objects;
    objects.resize(std::max<std::size_t>(surfels.size(), 1), 0);
    const auto samples = static_cast<std::size_t>(options.samples);
    const PixelGrid grid{static_cast<int>(width * samples), static_cast<int>(height * samples),
                         frame.tan_half * static_cast<double>(width) / static_cast<double>(height), frame.tan_half,
                         frame.parallel};
    const DrawnGeometry geometry = drawn_geometry(surfels, objects, emitters, frame, grid,
                                                  {options.footprint, options.culling, true, options.walls});

    const std::size_t count = options.rows.within(height), pixels = width * count;
    SplatImage image{width, count, {}, {}, {}, {}, {}};
    image.layers.assign(layers.size(), std::vector<float>(3 * pixels));
    image.coverage.resize(pixels);
    image.depth.resize(pixels, std::numeric_limits<float>::infinity());
    image.normal.resize(3 * pixels);
    image.index.resize(pixels, -1);
    const Resolver resolver{surfels, layers, emitters, frame, samples};
    const std::size_t rows = std::max<std::size_t>(1, subpixels_at_once / (width * samples * samples));
    Steps steps;
    const auto draw = [&](const gl::Context& context) {
        check_drawable(context.gl, grid.width, static_cast<GLsizei>(std::min(rows, count) * samples));
        const Painter painter(context.gl, geometry, layers, grid);
        for (std::size_t first = 0; first < count && steps.go_on(first); first += rows) {
            const std::size_t part = std::min(rows, count - first);
            const Raw raw = painter.draw(static_cast<int>((options.rows.first + first) * samples),
                                         static_cast<int>(part * samples));
            parallel_for(part, 8, [&](std::size_t y) { resolver.row(raw, first, first + y, image); });
        }
    };
    steps.watch([&] { gl::run_pass(draw, api); }, progress, count);
    return image;
}

}  // namespace surflux
