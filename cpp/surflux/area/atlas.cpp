#include "surflux/area/atlas.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <future>
#include <memory>
#include <mutex>
#include <string>

#include "surflux/area/atlas_shaders.h"
#include "surflux/area/atlas_tiles.h"
#include "surflux/core/parallel.h"
#include "surflux/gl/objects.h"

namespace surflux {

namespace {

// In a buffer of a size that every driver takes in one block (128 MiB is promised), and a bound on what waits in
// memory.
constexpr std::size_t most_quads = 1u << 20;

void use(const gl::Functions& gl, const gl::Program& program, const TileLayout& layout) {
    program.use();
    gl.Uniform2f(program.uniform("atlas"), static_cast<float>(layout.across * layout.width),
                 static_cast<float>(layout.down * layout.height));
    gl.Uniform2i(program.uniform("size"), layout.width, layout.height);
    gl.Uniform2i(program.uniform("tiles"), layout.across, layout.down);
}

template <class Quad>
void add_quads(const gl::Functions& gl, const std::vector<Quad>& quads) {
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_ONE, GL_ONE);
    for (std::size_t begin = 0; begin < quads.size(); begin += most_quads) {
        const std::size_t count = std::min(most_quads, quads.size() - begin);
        const gl::Buffer buffer(gl, quads.data() + begin, count * sizeof(Quad));
        buffer.bind(0);
        gl.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(6 * count));
    }
    gl.Disable(GL_BLEND);
}

constexpr float zero[4] = {0, 0, 0, 0};

gl::Texture target(const gl::Functions& gl, const TileLayout& layout, GLenum format) {
    return gl::Texture(gl, format, layout.across * layout.width, layout.down * layout.height);
}

// What draws a batch; lives on the thread of its context.
class Atlas {
public:
    Atlas(const gl::Functions& functions, const TileLayout& tile_layout)
        : gl(functions), layout(tile_layout), sums(target(gl, layout, GL_RGBA32F)), into_sums(gl, {&sums}) {
        gl::require_storage_buffers(gl);
        gl.GenVertexArrays(1, &vertex_array_);  // core GL draws nothing without one, though no attribute comes from it
        gl.BindVertexArray(vertex_array_);
        gl.Viewport(0, 0, layout.across * layout.width, layout.down * layout.height);
    }
    virtual ~Atlas() = default;

    // Appends the areas of the batch's disks.
    void draw(const TileBatch& batch, std::vector<double>& out) const {
        accumulate(batch);
        const gl::Buffer areas(gl, nullptr, batch.count() * sizeof(float));
        areas.bind(0);
        normalize();
        gl.DispatchCompute(static_cast<GLuint>(batch.count()), 1, 1);
        std::vector<float> shares(batch.count());
        areas.read(shares.data(), batch.count() * sizeof(float));
        for (std::size_t k = 0; k < batch.count(); ++k)
            out.push_back(batch.radii[k] * batch.radii[k] * static_cast<double>(shares[k]));
    }

protected:
    virtual void accumulate(const TileBatch& batch) const = 0;
    // Makes ready what sums the tiles.
    virtual void normalize() const = 0;

    const gl::Functions& gl;
    const TileLayout layout;
    const gl::Texture sums;
    const gl::Framebuffer into_sums;

private:
    GLuint vertex_array_ = 0;
};

class FlatAtlas : public Atlas {
public:
    FlatAtlas(const gl::Functions& functions, const TileLayout& tile_layout, double kappa)
        : Atlas(functions, tile_layout),
          falloff_(static_cast<float>(-kappa / std::log(2.0))),
          quads_(gl, atlas_shaders::flat_vertex, atlas_shaders::flat_fragment),
          sum_(gl, atlas_shaders::flat_sum) {}

protected:
    void accumulate(const TileBatch& batch) const override {
        into_sums.bind();
        gl.ClearBufferfv(GL_COLOR, 0, zero);
        use(gl, quads_, layout);
        gl.Uniform1f(quads_.uniform("falloff"), falloff_);
        add_quads(gl, batch.flat);
    }

    void normalize() const override {
        use(gl, sum_, layout);
        gl.Uniform1f(sum_.uniform("falloff"), falloff_);
        sums.bind(0);
    }

private:
    const float falloff_;
    const gl::Program quads_, sum_;
};

class CurvedAtlas : public Atlas {
public:
    CurvedAtlas(const gl::Functions& functions, const TileLayout& tile_layout, double kappa, const PolarGrid& grid)
        : Atlas(functions, tile_layout),
          kappa_(static_cast<float>(kappa)),
          directions_(gl, GL_RG32F, layout.width, 1),
          rings_(gl, GL_RGBA32F, layout.height, 2),
          rims_(target(gl, layout, GL_RG32F)),
          heights_(target(gl, layout, GL_RGBA32F)),
          areas_(target(gl, layout, GL_RGBA32F)),
          into_surface_(gl, {&rims_, &heights_, &areas_}),
          surface_(gl, atlas_shaders::surface_vertex, atlas_shaders::surface_fragment),
          quads_(gl, atlas_shaders::curved_vertex,
                 ((kappa_ == 3.0f ? "#version 430\n#define CUBED\n" : "#version 430\n") +
                  std::string(atlas_shaders::curved_fragment))
                     .c_str()),
          sum_(gl, atlas_shaders::curved_sum) {
        std::vector<float> directions;
        for (std::size_t d = 0; d < grid.cosine.size(); ++d) {
            directions.push_back(grid.cosine[d]);
            directions.push_back(grid.sine[d]);
        }
        directions_.write(layout.width, 1, GL_RG, GL_FLOAT, directions.data());
        // Texels are filled up with points at the rim that stand for no area.
        const auto texels = static_cast<std::size_t>(layout.height * rings_per_texel);
        std::vector<float> rings = grid.radius;
        rings.resize(texels, 1.0f);
        rings.insert(rings.end(), grid.weight.begin(), grid.weight.end());
        rings.resize(2 * texels, 0.0f);
        rings_.write(layout.height, 2, GL_RGBA, GL_FLOAT, rings.data());
    }

protected:
    void accumulate(const TileBatch& batch) const override {
        into_surface_.bind();
        use(gl, surface_, layout);
        directions_.bind(0);
        rings_.bind(1);
        std::vector<HalfPlaneTexel> half_planes = batch.ends;
        half_planes.emplace_back();  // an empty buffer is none
        const gl::Buffer tiles(gl, batch.tiles), ends(gl, half_planes);
        tiles.bind(0);
        ends.bind(1);
        gl.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(6 * batch.count()));

        into_sums.bind();
        gl.ClearBufferfv(GL_COLOR, 0, zero);
        use(gl, quads_, layout);
        gl.Uniform1f(quads_.uniform("kappa"), kappa_);
        rims_.bind(0);
        heights_.bind(1);
        rings_.bind(2);
        add_quads(gl, batch.curved);
    }

    void normalize() const override {
        use(gl, sum_, layout);
        rims_.bind(0);
        heights_.bind(1);
        rings_.bind(2);
        areas_.bind(3);
        sums.bind(4);
    }

private:
    const float kappa_;
    const gl::Texture directions_, rings_, rims_, heights_, areas_;
    const gl::Framebuffer into_surface_;
    const gl::Program surface_, quads_, sum_;
};

// Batches on their way from the thread that gathers them to the one that draws them, one at a time.
class Handover {
public:
    // Waits until the one before is drawn. False where nothing is drawn any more.
    bool put(TileBatch& batch) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return closed_ || !waiting_; });
        if (closed_) return false;
        batch_ = std::move(batch);
        waiting_ = true;
        changed_.notify_all();
        return true;
    }
    // The batch to draw, or null where there is no other.
    const TileBatch* next() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return closed_ || waiting_; });
        return waiting_ ? &batch_ : nullptr;
    }
    void drawn() {
        const std::lock_guard lock(mutex_);
        waiting_ = false;
        changed_.notify_all();
    }
    void close() {
        const std::lock_guard lock(mutex_);
        closed_ = true;
        changed_.notify_all();
    }

private:
    std::mutex mutex_;
    std::condition_variable changed_;
    TileBatch batch_;
    bool waiting_ = false, closed_ = false;
};

struct Closer {
    Handover& handover;
    ~Closer() { handover.close(); }
};

}  // namespace

bool atlas_may_pay(std::size_t disks, const AreaOptions& options, int threads) {
    // Points that a thread weighs in a second, with AVX-512.
    const double rate = options.method == AreaMethod::paper ? 3e8 : 1.1e9;
    const double seconds_each = options.resolution * options.resolution / rate;
    // Neighbourhoods are found on the CPU either way, 1 to 3 microseconds each, and making quads of them adds to that.
    // A context and its shaders are ready after a tenth of a second or more.
    return seconds_each > 2e-6 && seconds_each * static_cast<double>(disks) > 0.5 * threads;
}

std::vector<double> atlas_areas(const NeighborhoodFinder& finder, const AreaOptions& options,
                                const Progress& progress) {
    const bool curved = options.method == AreaMethod::curved;
    const std::vector<std::uint32_t>& disks = finder.disks();
    if (disks.empty()) return {};
    const TileLayout layout(options.method, options.resolution);
    const PolarGrid grid(options.resolution);
    std::vector<double> areas;
    areas.reserve(disks.size());

    const auto gather = [&](std::size_t begin) {
        TileBatch batch;
        while (batch.count() < layout.count() && begin + batch.count() < disks.size() &&
               std::max(batch.flat.size(), batch.curved.size()) < most_quads) {
            constexpr std::size_t together = 512, grain = 32;
            const std::size_t first = begin + batch.count();
            const std::size_t count = std::min({together, layout.count() - batch.count(), disks.size() - first});
            std::vector<TileBatch> parts((count + grain - 1) / grain);
            parallel_blocks(count, grain, [&](std::size_t low, std::size_t high) {
                Neighborhood around;
                TileBatch& part = parts[low / grain];
                for (std::size_t k = low; k < high; ++k) {
                    finder.find(disks[first + k], curved, around);
                    if (curved) {
                        add_curved_tile(around, grid, layout, first + k - begin, part);
                    } else {
                        add_flat_tile(around, options.resolution, layout, first + k - begin, part);
                    }
                }
            });
            for (const TileBatch& part : parts) batch.append(part);
        }
        return batch;
    };

    Handover handover;
    const auto draw_all = [&](const gl::Context& context) {
        std::unique_ptr<Atlas> atlas;
        if (curved)
            atlas = std::make_unique<CurvedAtlas>(context.gl, layout, options.kappa, grid);
        else
            atlas = std::make_unique<FlatAtlas>(context.gl, layout, options.kappa);
        while (const TileBatch* batch = handover.next()) {
            atlas->draw(*batch, areas);
            handover.drawn();
        }
    };
    std::future<void> drawing = std::async(std::launch::async, [&] {
        const Closer closer{handover};
        gl::run_pass(draw_all);
    });
    {
        const Closer closer{handover};
        for (std::size_t begin = 0; begin < disks.size();) {
            TileBatch batch = gather(begin);
            const std::size_t count = batch.count();
            if (!handover.put(batch)) break;
            report(progress, begin, disks.size());
            begin += count;
        }
    }
    drawing.get();
    report(progress, disks.size(), disks.size());
    return areas;
}

}  // namespace surflux
