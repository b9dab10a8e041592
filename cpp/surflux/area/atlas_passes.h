#pragma once

#include <memory>
#include <vector>

#include "surflux/area/atlas_tiles.h"
#include "surflux/gl/objects.h"

namespace surflux {

// No buffer of ours holds more quads: every driver takes it in one block (128 MiB is promised).
constexpr std::size_t most_quads = 1u << 20;

// What draws batches of tiles. Lives on the thread of its context.
class Atlas {
public:
    virtual ~Atlas() = default;

    // Appends the areas of the batch's disks.
    void draw(const TileBatch& batch, std::vector<double>& out) const;

protected:
    Atlas(const gl::Functions& functions, const TileLayout& tile_layout);

    // Adds up the neighbours' weights in `sums`.
    virtual void accumulate(const TileBatch& batch) const = 0;
    // Makes ready the compute shader that normalizes the texels and sums those of a tile.
    virtual void normalize() const = 0;

    const gl::Functions& gl;
    const TileLayout layout;
    const gl::Texture sums;
    const gl::Framebuffer into_sums;
};

// For the method of the options. Throws DeviceError.
std::unique_ptr<Atlas> make_atlas(const gl::Functions& gl, const TileLayout& layout, const AreaOptions& options,
                                  const PolarGrid& grid);

}  // namespace surflux
