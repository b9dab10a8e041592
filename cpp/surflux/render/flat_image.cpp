#include "surflux/render/flat_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "surflux/core/parallel.h"
#include "surflux/render/surface_pass.h"

namespace surflux {

namespace {

constexpr std::size_t subpixels_at_once = 1u << 20;  // of a band that OpenGL draws
constexpr std::size_t rows_of_block = 4;             // pixels

// What each subpixel of a band sees, as SurfacePass leaves it.
struct Seen {
    std::vector<float> surface;       // depth, normal in the camera's frame
    std::vector<std::int32_t> names;  // surfel, group
};

// The rows of the matrix of some rows of pixels.
struct Block {
    std::vector<std::uint32_t> sizes, columns;  // sizes: of each pixel
    std::vector<float> weights;
    std::vector<float> coverage;  // of each pixel
};

struct Entry {
    std::uint32_t place;  // subpixel of the block
    std::uint32_t column;
    float weight;
};

float smoothstep(float low, float high, float x) {
    const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

float dot3(const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// kernel_fragment of splat_shaders.h, for one subpixel.
class KernelWeight {
public:
    KernelWeight(const DrawnKernel& k, const std::vector<WallTrace>& walls)
        : k_(k), walls_(walls.data() + k.walls[0]), walls_end_(walls.data() + k.walls[1]) {
        const float *n = k.normal, *u = k.direction;
        const float across[3] = {n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0]};
        std::copy(across, across + 3, across_);
        low_ = 0.5f * k.agreement;
        high_ = 0.5f + (0.95f - 0.5f) * k.agreement;
    }

    float at(const float* place, const float* normal) const {
        const float d[3] = {place[0] - k_.center[0], place[1] - k_.center[1], place[2] - k_.center[2]};
        const float local[3] = {dot3(d, k_.direction), dot3(d, across_), dot3(d, k_.normal)};
        const float s = local[0] * local[0] * k_.shrink[0] + local[1] * local[1] * k_.shrink[1] +
                        local[2] * local[2] * k_.shrink[2];
        if (!(s < 1.0f)) return 0.0f;
        const float agreement = smoothstep(low_, high_, dot3(normal, k_.normal));
        const float weight = k_.amplitude * agreement * std::exp(-2.0f * s) * (1.0f - s) * (1.0f - s);
        return is_behind(walls_, walls_end_, local[0], local[1]) ? 1e-6f * weight : weight;
    }

private:
    const DrawnKernel& k_;
    const WallTrace *walls_, *walls_end_;
    float across_[3], low_, high_;
};

class Flattener {
public:
    Flattener(const DrawnGeometry& geometry, const PixelGrid& grid, std::size_t surfels, std::size_t emitters,
              std::size_t samples)
        : geometry_(geometry), grid_(grid), surfels_(surfels), emitters_(emitters), samples_(samples) {}

    // Rows [first, first + count) of pixels, which `seen` holds the subpixels of.
    std::vector<Block> blocks(const Seen& seen, std::size_t first, std::size_t count) const {
        std::vector<Block> out((count + rows_of_block - 1) / rows_of_block);
        std::vector<std::vector<std::uint32_t>> kernels(out.size());
        const auto top = static_cast<int>(first * samples_), side = static_cast<int>(rows_of_block * samples_);
        const int last = static_cast<int>(count * samples_);
        for (std::size_t k = 0; k < geometry_.kernels.size(); ++k) {
            const int low = std::max(geometry_.kernels[k].box[1] - top, 0);
            const int high = std::min(geometry_.kernels[k].box[3] - top, last);
            for (int block = low / side; block * side < high; ++block)
                kernels[static_cast<std::size_t>(block)].push_back(static_cast<std::uint32_t>(k));
        }
        parallel_for(out.size(), 1, [&](std::size_t b) {
            const std::size_t begin = b * rows_of_block;
            out[b] = block(seen, kernels[b], top, begin, std::min(rows_of_block, count - begin));
        });
        return out;
    }

private:
    Block block(const Seen& seen, const std::vector<std::uint32_t>& kernels, int top, std::size_t begin,
                std::size_t rows) const {
        const auto width = static_cast<std::size_t>(grid_.width);
        const std::size_t offset = begin * samples_ * width, size = rows * samples_ * width;
        const std::vector<std::array<float, 3>> places = places_of(seen, top, begin * samples_, size);
        const auto low = top + static_cast<int>(begin * samples_);
        const auto high = low + static_cast<int>(rows * samples_);
        std::vector<Entry> found;
        for (const std::uint32_t number : kernels) {
            const DrawnKernel& kernel = geometry_.kernels[number];
            const KernelWeight weight(kernel, geometry_.walls);
            for (int y = std::max(kernel.box[1], low); y < std::min(kernel.box[3], high); ++y) {
                for (int x = std::max(kernel.box[0], 0); x < std::min(kernel.box[2], grid_.width); ++x) {
                    const std::size_t at = static_cast<std::size_t>(y - low) * width + static_cast<std::size_t>(x);
                    if (seen.names[2 * (offset + at) + 1] != kernel.group) continue;
                    const float w = weight.at(places[at].data(), &seen.surface[4 * (offset + at) + 1]);
                    if (w > 0.0f)
                        found.push_back({static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(kernel.index), w});
                }
            }
        }
        return merged(seen, offset, rows, by_place(found, size));
    }

    // The point that each subpixel sees, in the camera's frame.
    std::vector<std::array<float, 3>> places_of(const Seen& seen, int top, std::size_t row, std::size_t size) const {
        const auto width = static_cast<std::size_t>(grid_.width);
        const float step_x = 2.0f * static_cast<float>(grid_.tan_x) / static_cast<float>(grid_.width);
        const float step_y = 2.0f * static_cast<float>(grid_.tan_y) / static_cast<float>(grid_.height);
        std::vector<std::array<float, 3>> places(size);
        for (std::size_t at = 0; at < size; ++at) {
            const float depth = seen.surface[4 * (row * width + at)];
            const float x = step_x * (static_cast<float>(at % width) + 0.5f) - static_cast<float>(grid_.tan_x);
            const float line = static_cast<float>(top) + static_cast<float>(row + at / width) + 0.5f;
            const float y = step_y * line - static_cast<float>(grid_.tan_y), far = grid_.parallel ? 1.0f : depth;
            places[at] = {x * far, y * far, depth};
        }
        return places;
    }

    // Entries sorted by subpixel, otherwise in their order: of each where they begin, and the end.
    static std::pair<std::vector<Entry>, std::vector<std::uint32_t>> by_place(const std::vector<Entry>& found,
                                                                              std::size_t size) {
        std::vector<std::uint32_t> begin(size + 1, 0);
        for (const Entry& entry : found) ++begin[entry.place + 1];
        for (std::size_t k = 0; k < size; ++k) begin[k + 1] += begin[k];
        std::vector<Entry> sorted(found.size());
        std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
        for (const Entry& entry : found) sorted[next[entry.place]++] = entry;
        return {std::move(sorted), std::move(begin)};
    }

    // Normalizes every subpixel and averages those of a pixel.
    Block merged(const Seen& seen, std::size_t offset, std::size_t rows,
                 const std::pair<std::vector<Entry>, std::vector<std::uint32_t>>& entries) const {
        const auto& [sorted, begin] = entries;
        const auto width = static_cast<std::size_t>(grid_.width);
        const std::size_t pixels = width / samples_;
        const float share = 1.0f / static_cast<float>(samples_ * samples_);
        Block out;
        std::vector<std::pair<std::uint32_t, float>> of_pixel;
        for (std::size_t pixel = 0; pixel < rows * pixels; ++pixel) {
            of_pixel.clear();
            std::size_t covered = 0;
            for (std::size_t k = 0; k < samples_ * samples_; ++k) {
                const std::size_t at =
                    (pixel / pixels * samples_ + k / samples_) * width + pixel % pixels * samples_ + k % samples_;
                const std::int32_t index = seen.names[2 * (offset + at)];
                if (index == -1) continue;
                ++covered;
                float sum = 0.0f;
                for (std::uint32_t e = begin[at]; e < begin[at + 1]; ++e) sum += sorted[e].weight;
                // As Resolver::color_of has it.
                if (index < 0 || !(sum > 0.0f)) {
                    of_pixel.emplace_back(column_of(index), share);
                    continue;
                }
                for (std::uint32_t e = begin[at]; e < begin[at + 1]; ++e)
                    of_pixel.emplace_back(sorted[e].column, share * sorted[e].weight / sum);
            }
            std::sort(of_pixel.begin(), of_pixel.end());
            std::uint32_t size = 0;
            for (std::size_t k = 0; k < of_pixel.size(); ++k) {
                if (k > 0 && of_pixel[k].first == of_pixel[k - 1].first) {
                    out.weights.back() += of_pixel[k].second;
                    continue;
                }
                out.columns.push_back(of_pixel[k].first);
                out.weights.push_back(of_pixel[k].second);
                ++size;
            }
            out.sizes.push_back(size);
            out.coverage.push_back(
                static_cast<float>(static_cast<double>(covered) / static_cast<double>(samples_ * samples_)));
        }
        return out;
    }

    std::uint32_t column_of(std::int32_t index) const {
        if (index >= 0) return static_cast<std::uint32_t>(index);
        return static_cast<std::uint32_t>(surfels_) + static_cast<std::uint32_t>(-2 - index);
    }

    const DrawnGeometry& geometry_;
    const PixelGrid& grid_;
    std::size_t surfels_, emitters_, samples_;
};

}  // namespace

std::vector<float> FlatImage::draw(const std::vector<Rgb>& values, const std::vector<Rgb>& emitters) const {
    require(values.size() == surfels_, "values: wanted one RGB value for each of ", surfels_, " surfels, got ",
            values.size());
    require(emitters.size() == emitters_, "emitters: wanted the radiance of each of ", emitters_, ", got ",
            emitters.size());
    std::vector<std::array<float, 4>> all(surfels_ + emitters_);
    for (std::size_t k = 0; k < all.size(); ++k) {
        const Rgb& value = k < surfels_ ? values[k] : emitters[k - surfels_];
        require(is_finite(value), "values: wanted finite numbers");
        store(all[k].data(), value);
    }
    std::vector<float> image(3 * width_ * height_);
    parallel_for(width_ * height_, 4096, [&](std::size_t pixel) {
        float sum[4] = {0, 0, 0, 0};
        for (std::uint64_t e = begin_[pixel]; e < begin_[pixel + 1]; ++e)
            for (int c = 0; c < 4; ++c) sum[c] += weights_[e] * all[columns_[e]][static_cast<std::size_t>(c)];
        for (std::size_t c = 0; c < 3; ++c) image[3 * pixel + c] = sum[c];
    });
    return image;
}

std::size_t FlatImage::bytes() const {
    return begin_.size() * sizeof(begin_[0]) + columns_.size() * (sizeof(columns_[0]) + sizeof(weights_[0])) +
           coverage_.size() * sizeof(coverage_[0]);
}

FlatImage flat_image(const Surfels& surfels, const std::vector<VisibleEmitter>& emitters, const Camera& camera,
                     std::size_t width, std::size_t height, const SplatOptions& options, gl::Api api) {
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
    const Flattener flattener(geometry, grid, surfels.size(), emitters.size(), samples);
    FlatImage image;
    image.width_ = width;
    image.height_ = height;
    image.surfels_ = surfels.size();
    image.emitters_ = emitters.size();
    image.begin_.reserve(width * height + 1);
    image.begin_.push_back(0);
    const std::size_t rows = std::max<std::size_t>(1, subpixels_at_once / (width * samples * samples));
    gl::run_pass(
        [&](const gl::Context& context) {
            const gl::Functions& gl = context.gl;
            check_drawable(gl, grid.width, static_cast<GLsizei>(std::min(rows, height) * samples));
            for (std::size_t first = 0; first < height; first += rows) {
                const std::size_t part = std::min(rows, height - first);
                const auto lines = static_cast<GLsizei>(part * samples);
                const DrawnView view(grid, static_cast<int>(first * samples), lines, geometry.far_depth);
                const SurfacePass visibility(gl, view, geometry.disks, geometry.triangles);
                const std::size_t subpixels = static_cast<std::size_t>(grid.width) * part * samples;
                Seen seen{std::vector<float>(4 * subpixels), std::vector<std::int32_t>(2 * subpixels)};
                visibility.target.read(0, grid.width, lines, GL_RGBA, GL_FLOAT, seen.surface.data());
                visibility.target.read(1, grid.width, lines, GL_RG_INTEGER, GL_INT, seen.names.data());
                for (const Block& block : flattener.blocks(seen, first, part)) {
                    for (const std::uint32_t size : block.sizes) image.begin_.push_back(image.begin_.back() + size);
                    image.columns_.insert(image.columns_.end(), block.columns.begin(), block.columns.end());
                    image.weights_.insert(image.weights_.end(), block.weights.begin(), block.weights.end());
                    image.coverage_.insert(image.coverage_.end(), block.coverage.begin(), block.coverage.end());
                }
            }
        },
        api);
    return image;
}

}  // namespace surflux
