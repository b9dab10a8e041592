#pragma once

// What the atlas draws for each surfel, as its shaders read it (std430). A tile is a rectangle of texels in which one
// surfel's disk is integrated; texel (x, y) of the tile stands at `origin` + (x, y) in the atlas.

#include <cstdint>
#include <vector>

#include "surflux/area/effective_area.h"
#include "surflux/area/neighborhood.h"
#include "surflux/area/polar_grid.h"

namespace surflux {

// What shares a texel: two pixels of a row, of which the paper's method needs two numbers each; four consecutive rings
// of a direction, of which the curved one needs one.
constexpr int pixels_per_texel = 2, rings_per_texel = 4;

// Texels [x0, x1) x [y0, y1) of the atlas, and the corner of the tile that they are in.
struct TexelRange {
    std::uint16_t x0, y0, x1, y1, origin_x, origin_y, unused[2];
};

// D04's quad. Where n_i projects it, disk j has its centre at (cx, cy), in pixels from the middle of disk i; a point
// (dx, dy) pixels away has the coordinates (ax dx + ay dy, bx dx + by dy) in disk j, in units of R_j.
struct FlatQuad {
    float ax, ay, bx, by;
    float cx, cy, stretch, unused;  // stretch: dA_j / dA_i = 1 / (n_i . n_j), D04 eq. 8
    TexelRange range;
};

// One that shares disk i, seen from the surfel's own place on the model.
struct CurvedQuad {
    float x, y, z, inverse_square_radius;
    TexelRange range;
};

// The model of the surface (surface_fit.h) and which half planes end the disk.
struct CurvedTile {
    float kxx, kxy, kyy, gx;
    float gy;
    std::uint32_t first_end, ends, unused;
};

struct HalfPlaneTexel {
    float x, y, limit, unused;
};

// How the tiles lie.
struct TileLayout {
    // OpenGL 4.3 promises textures of 16384 texels a side; the atlas is far from that.
    TileLayout(AreaMethod method, int resolution);

    int width, height;  // of a tile
    int across, down;   // tiles in the atlas
    std::size_t count() const { return static_cast<std::size_t>(across) * static_cast<std::size_t>(down); }
};

// Some surfels' tiles, one after another.
struct TileBatch {
    std::vector<FlatQuad> flat;
    std::vector<CurvedQuad> curved;
    std::vector<CurvedTile> tiles;
    std::vector<HalfPlaneTexel> ends;
    std::vector<double> radii;  // of each tile's disk

    std::size_t count() const { return radii.size(); }
    void append(const TileBatch& other);
};

// Adds the neighbourhood as the next tile: as a tile at `place`.
void add_flat_tile(const Neighborhood& around, int resolution, const TileLayout& layout, std::size_t place,
                   TileBatch& batch);
void add_curved_tile(const Neighborhood& around, const PolarGrid& grid, const TileLayout& layout, std::size_t place,
                     TileBatch& batch);

}  // namespace surflux
