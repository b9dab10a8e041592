#include "surflux/area/atlas_passes.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "surflux/area/atlas_shaders.h"

namespace surflux {

namespace {

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

}  // namespace

Atlas::Atlas(const gl::Functions& functions, const TileLayout& tile_layout)
    : gl(functions), layout(tile_layout), sums(target(gl, layout, GL_RGBA32F)), into_sums(gl, {&sums}) {
    gl::require_storage_buffers(gl);
    gl.Viewport(0, 0, layout.across * layout.width, layout.down * layout.height);
}

void Atlas::draw(const TileBatch& batch, std::vector<double>& out) const {
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

std::unique_ptr<Atlas> make_atlas(const gl::Functions& gl, const TileLayout& layout, const AreaOptions& options,
                                  const PolarGrid& grid) {
    if (options.method == AreaMethod::paper) return std::make_unique<FlatAtlas>(gl, layout, options.kappa);
    return std::make_unique<CurvedAtlas>(gl, layout, options.kappa, grid);
}

}  // namespace surflux
