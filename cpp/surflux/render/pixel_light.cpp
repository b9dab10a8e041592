#include "surflux/render/pixel_light.h"

#include <algorithm>
#include <atomic>
#include <memory>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/emitter.h"

namespace surflux {

namespace {

constexpr std::size_t grain = 256;             // pixels whose rays are traced one after another
constexpr std::uint64_t light_stream = 0x91c;  // of random numbers, by light
// In place of what is visible: of a cell whose probe the light does not shine on, and of a pixel on which it does not.
constexpr float unknown = -1.0f, unlit = -2.0f;

using Pixels = std::vector<std::uint32_t>;

// Pixels numbered tile after tile, so that rays of those that follow each other stay close together.
class PixelTiles {
public:
    PixelTiles(std::size_t width, std::size_t height)
        : width_(width), height_(height), across_((width + side - 1) / side) {}
    std::size_t rows() const { return (height_ + side - 1) / side; }
    template <class Visit>
    void for_row(std::size_t row, const Visit& visit) const {
        for (std::size_t left = 0; left < width_; left += side)
            for (std::size_t y = row * side; y < std::min((row + 1) * side, height_); ++y)
                for (std::size_t x = left; x < std::min(left + side, width_); ++x) visit(y * width_ + x);
    }
    std::size_t number(std::size_t pixel) const {
        const std::size_t x = pixel % width_, y = pixel / width_;
        return ((y / side * across_ + x / side) * side + y % side) * side + x % side;
    }
    std::size_t pixel(std::size_t number) const {
        const std::size_t tile = number / (side * side), in = number % (side * side);
        return (tile / across_ * side + in / side) * width_ + tile % across_ * side + in % side;
    }

private:
    static constexpr std::size_t side = 16;
    std::size_t width_, height_, across_;
};

class OneLight {
public:
    OneLight(const Tracer& tracer, const PixelPlaces& places, const SmoothCells& cells, const Emitter& light,
             const PixelLightOptions& options, PixelLight::Scratch& scratch)
        : tracer_(tracer), places_(places), cells_(cells), light_(light), options_(options), scratch_(scratch) {}

    // kernel and visible of the scratch.
    std::size_t find() {
        find_kernels();
        trace_probes();
        for (Pixels open = first_open(); !open.empty(); open = next_open(open)) trace(open);
        return rays_;
    }

private:
    std::uint64_t seed() const { return options_.seed + light_stream + light_.index; }

    void find_kernels() {
        scratch_.kernel.resize(places_.size());
        parallel_for(places_.size(), 4096, [&](std::size_t p) {
            scratch_.kernel[p] = places_.is_seen(p)
                                     ? static_cast<float>(light_.kernel_at(places_.place(p), places_.normal_at(p)))
                                     : 0.0f;
        });
    }

    Ray ray_to(std::size_t pixel, const Vec3& light) const {
        const Departure from{places_.place(pixel), places_.normal_at(pixel), places_.surfel[pixel]};
        return light_.distant ? Ray{from, light} : segment(from, light);
    }

    // What a probe sees of the light holds for its cell, until a neighbour contradicts it.
    void trace_probes() {
        const Pixels& probes = cells_.probes();
        scratch_.at_probes.assign(probes.size(), unknown);
        scratch_.is_traced.assign(places_.size(), 0);
        scratch_.visible.resize(places_.size());
        if (cells_.is_each_pixel()) return;
        parallel_blocks(probes.size(), grain, [&](std::size_t begin, std::size_t end) {
            std::vector<Ray> rays;
            std::vector<char> free;
            std::vector<std::size_t> of;
            for (std::size_t k = begin; k < end; ++k) {
                const std::size_t p = probes[k];
                if (!(scratch_.kernel[p] > 0.0f)) continue;
                EvenPoints even(2, seed(), p);
                const double* u = even.next();
                rays.push_back(ray_to(p, light_.arrival(places_.place(p), places_.normal_at(p), u[0], u[1]).from));
                of.push_back(k);
            }
            tracer_.free_coherent(rays, free);
            for (std::size_t r = 0; r < rays.size(); ++r) {
                scratch_.at_probes[of[r]] = free[r] ? 1.0f : 0.0f;
                if (!light_.extended) scratch_.is_traced[probes[of[r]]] = 1;
            }
            rays_ += rays.size();
        });
    }

    float presumed(std::size_t pixel) const { return scratch_.at_probes[cells_.cell(pixel)]; }
    bool is_lit(std::size_t pixel) const { return scratch_.kernel[pixel] > 0.0f; }

    // Pixels whose cell knows nothing of the light, or another one beside them something else.
    Pixels first_open() {
        parallel_for(places_.size(), 4096,
                     [&](std::size_t p) { scratch_.visible[p] = is_lit(p) ? presumed(p) : unlit; });
        const PixelTiles tiles(places_.rays.width, places_.rays.height);
        std::vector<Pixels> parts(tiles.rows());
        parallel_for(tiles.rows(), 1, [&](std::size_t row) {
            tiles.for_row(row, [&](std::size_t p) {
                const float here = scratch_.visible[p];
                if (here == unlit || scratch_.is_traced[p]) return;
                bool open = here == unknown;
                cells_.for_neighbors(p, [&](std::size_t q) {
                    open = open || (scratch_.visible[q] != here && scratch_.visible[q] != unlit);
                });
                if (open) parts[row].push_back(static_cast<std::uint32_t>(p));
            });
        });
        return together(parts);
    }

    void trace(const Pixels& pixels) {
        const int count = light_.extended ? options_.penumbra_rays : 1;
        parallel_blocks(pixels.size(), grain, [&](std::size_t begin, std::size_t end) {
            std::vector<Ray> rays;
            std::vector<double> kernels;
            std::vector<char> free;
            for (std::size_t k = begin; k < end; ++k) {
                const std::size_t p = pixels[k];
                EvenPoints even(2, seed(), p);
                for (int r = 0; r < count; ++r) {
                    const double* u = even.next();
                    const Arrival arrival = light_.arrival(places_.place(p), places_.normal_at(p), u[0], u[1]);
                    rays.push_back(ray_to(p, arrival.from));
                    kernels.push_back(arrival.kernel);
                }
            }
            tracer_.free_coherent(rays, free);
            std::size_t r = 0;
            for (std::size_t k = begin; k < end; ++k) {
                // A ratio estimator: of the light's points, each counts for what it would bring.
                double all = 0.0, passed = 0.0, passes = 0.0;
                for (const std::size_t last = r + static_cast<std::size_t>(count); r < last; ++r) {
                    all += kernels[r];
                    if (free[r]) passed += kernels[r], passes += 1.0;
                }
                scratch_.visible[pixels[k]] = static_cast<float>(all > 0.0 ? passed / all : passes / count);
                scratch_.is_traced[pixels[k]] = 1;
            }
            rays_ += rays.size();
        });
    }

    // Pixels beside those just traced, or at their corners, that are presumed to see what these do not.
    Pixels next_open(const Pixels& traced) const {
        std::vector<Pixels> parts((traced.size() + grain - 1) / grain);
        parallel_blocks(traced.size(), grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const float here = scratch_.visible[traced[k]];
                const auto visit = [&](std::size_t q) {
                    if (is_lit(q) && !scratch_.is_traced[q] && scratch_.visible[q] != here)
                        parts[begin / grain].push_back(static_cast<std::uint32_t>(q));
                };
                cells_.for_neighbors(traced[k], visit);
                cells_.for_diagonals(traced[k], visit);
            }
        });
        const PixelTiles tiles(places_.rays.width, places_.rays.height);
        Pixels open = together(parts);
        for (std::uint32_t& p : open) p = static_cast<std::uint32_t>(tiles.number(p));
        std::sort(open.begin(), open.end());
        open.erase(std::unique(open.begin(), open.end()), open.end());
        for (std::uint32_t& p : open) p = static_cast<std::uint32_t>(tiles.pixel(p));
        return open;
    }

    static Pixels together(const std::vector<Pixels>& parts) {
        Pixels all;
        for (const Pixels& part : parts) all.insert(all.end(), part.begin(), part.end());
        return all;
    }

    const Tracer& tracer_;
    const PixelPlaces& places_;
    const SmoothCells& cells_;
    const Emitter& light_;
    const PixelLightOptions& options_;
    PixelLight::Scratch& scratch_;
    std::atomic<std::size_t> rays_{0};
};

}  // namespace

std::size_t PixelLight::irradiance(const std::vector<Light>& lights, const PixelLightOptions& options, Scratch& scratch,
                                   std::vector<float>& out) const {
    std::size_t rays = 0;
    const auto emitters = emitters_of(lights);
    if (emitters.empty()) out.assign(3 * places_.size(), 0.0f);
    out.resize(3 * places_.size());
    for (const std::unique_ptr<Emitter>& light : emitters) {
        rays += OneLight(tracer_, places_, cells_, *light, options, scratch).find();
        const bool is_first = light == emitters.front();
        float color[3];
        for (int c = 0; c < 3; ++c) color[c] = static_cast<float>(light->color[c]);
        parallel_for(places_.size(), 4096, [&](std::size_t p) {
            const float share = scratch.kernel[p] * scratch.visible[p];
            for (std::size_t c = 0; c < 3; ++c) out[3 * p + c] = color[c] * share + (is_first ? 0.0f : out[3 * p + c]);
        });
    }
    return rays;
}

}  // namespace surflux
