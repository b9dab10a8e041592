#include "surflux/area/atlas_tiles.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/sampling.h"

namespace surflux {

namespace {

// A batch's tiles take at most so many texels, 56 bytes each for the curved method, and so many tiles, so that a
// cancel does not wait long.
constexpr std::size_t most_texels = 1u << 20, most_tiles = 4096;

// What is left out lies this far outside, in units of the disk: single precision cannot bring it back in.
constexpr double margin = 1e-4;

struct Interval {
    double low, high;
};

// The texels whose centres lie in it, of `count` that divide [-1, 1].
void texels_of(const Interval& interval, int count, int& first, int& last) {
    const double step = 2.0 / count;
    first = std::max(0, static_cast<int>(std::ceil((interval.low + 1.0 - margin) / step - 0.5)));
    last = std::min(count, static_cast<int>(std::floor((interval.high + 1.0 + margin) / step - 0.5)) + 1);
}

// Half the chord of the unit circle where it is widest within the interval.
double widest_chord(const Interval& i) {
    const double nearest = i.low > 0.0 ? i.low : i.high < 0.0 ? -i.high : 0.0;
    return std::sqrt(std::max(0.0, 1.0 - nearest * nearest));
}

TexelRange range_of(const TileLayout& layout, std::size_t place, int x0, int y0, int x1, int y1) {
    const int row = static_cast<int>(place) / layout.across, column = static_cast<int>(place) % layout.across;
    const int x = column * layout.width, y = row * layout.height;
    const auto narrow = [](int v) { return static_cast<std::uint16_t>(v); };
    return {narrow(x + x0), narrow(y + y0), narrow(x + x1), narrow(y + y1), narrow(x), narrow(y), {0, 0}};
}

}  // namespace

TileLayout::TileLayout(AreaMethod method, int resolution) : width(resolution), height(resolution), across(1), down(1) {
    if (method == AreaMethod::paper) {
        width = (resolution + pixels_per_texel - 1) / pixels_per_texel;
    } else {
        const int rings = (resolution + 1) / 2;
        height = (rings + rings_per_texel - 1) / rings_per_texel;
    }
    const std::size_t texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    const std::size_t tiles = std::clamp<std::size_t>(most_texels / texels, 1, most_tiles);
    // About square.
    across = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(tiles * texels))) / width);
    down = std::max(1, static_cast<int>(tiles) / across);
}

void TileBatch::append(const TileBatch& other) {
    const auto shift = static_cast<std::uint32_t>(ends.size());
    flat.insert(flat.end(), other.flat.begin(), other.flat.end());
    curved.insert(curved.end(), other.curved.begin(), other.curved.end());
    ends.insert(ends.end(), other.ends.begin(), other.ends.end());
    for (CurvedTile tile : other.tiles) {
        tile.first_end += shift;
        tiles.push_back(tile);
    }
    radii.insert(radii.end(), other.radii.begin(), other.radii.end());
}

void add_flat_tile(const Neighborhood& around, int resolution, const TileLayout& layout, std::size_t place,
                   TileBatch& batch) {
    const double step = 2.0 / resolution;
    // The surfel's own disk covers its tile: its weight is known there and not drawn.
    for (std::size_t k = 1; k < around.surface.size(); ++k) {
        const Member& j = around.surface[k];
        const Vec3 &c = j.position, &n = j.normal;
        const double wide = j.radius * std::sqrt(std::max(0.0, 1.0 - n.x * n.x));
        const double high = j.radius * std::sqrt(std::max(0.0, 1.0 - n.y * n.y));
        Interval x{c.x - wide, c.x + wide}, y{c.y - high, c.y + high};
        const double chord_x = widest_chord(y), chord_y = widest_chord(x);
        x = {std::max(x.low, -chord_x), std::min(x.high, chord_x)};
        y = {std::max(y.low, -chord_y), std::min(y.high, chord_y)};
        int x0, y0, x1, y1;
        texels_of(x, resolution, x0, x1);
        texels_of(y, resolution, y0, y1);
        if (x0 >= x1 || y0 >= y1) continue;
        // Disk j's own axes, as n_i sees them: along its tilt it is n_z times as long.
        const double slope = std::hypot(n.x, n.y);
        const double ex = slope > 0.0 ? n.x / slope : 1.0, ey = slope > 0.0 ? n.y / slope : 0.0;
        const double a = 1.0 / (j.radius * n.z), b = 1.0 / j.radius;
        FlatQuad quad{};
        quad.ax = static_cast<float>(a * ex * step);
        quad.ay = static_cast<float>(a * ey * step);
        quad.bx = static_cast<float>(-b * ey * step);
        quad.by = static_cast<float>(b * ex * step);
        quad.cx = static_cast<float>(c.x / step);
        quad.cy = static_cast<float>(c.y / step);
        quad.stretch = static_cast<float>(1.0 / n.z);
        const int last = (x1 + pixels_per_texel - 1) / pixels_per_texel;
        quad.range = range_of(layout, place, x0 / pixels_per_texel, y0, last, y1);
        batch.flat.push_back(quad);
    }
    batch.radii.push_back(around.radius);
}

void add_curved_tile(const Neighborhood& around, const PolarGrid& grid, const TileLayout& layout, std::size_t place,
                     TileBatch& batch) {
    const SurfaceModel& m = around.model;
    CurvedTile tile{};
    tile.kxx = static_cast<float>(m.kxx);
    tile.kxy = static_cast<float>(m.kxy);
    tile.kyy = static_cast<float>(m.kyy);
    tile.gx = static_cast<float>(m.gx);
    tile.gy = static_cast<float>(m.gy);
    tile.first_end = static_cast<std::uint32_t>(batch.ends.size());
    tile.ends = static_cast<std::uint32_t>(around.ends.size());
    batch.tiles.push_back(tile);
    for (const HalfPlane& h : around.ends)
        batch.ends.push_back({static_cast<float>(h.x), static_cast<float>(h.y), static_cast<float>(h.limit), 0.0f});
    batch.radii.push_back(around.radius);

    const double step = 2.0 * pi / grid.directions;
    const auto add = [&](const Member& j) {
        const Vec3& c = j.position;
        const double away = std::hypot(c.x, c.y);
        // The texels that j may reach: rings from where it begins, directions as it is seen from the middle.
        const double begin = away - j.radius - margin;
        const auto ring = std::lower_bound(grid.radius.begin(), grid.radius.end(), static_cast<float>(begin));
        if (ring == grid.radius.end()) return;
        const int low = static_cast<int>(ring - grid.radius.begin()) / rings_per_texel;
        CurvedQuad quad{static_cast<float>(c.x),
                        static_cast<float>(c.y),
                        static_cast<float>(c.z - m.z0),
                        static_cast<float>(1.0 / (j.radius * j.radius)),
                        {}};
        const auto put = [&](int first, int last) {
            if (first >= last) return;
            quad.range = range_of(layout, place, first, low, last, layout.height);
            batch.curved.push_back(quad);
        };
        int first = 0, last = grid.directions;
        if (away > j.radius) {
            const double middle = std::atan2(c.y, c.x), half = std::asin(j.radius / away) + margin;
            first = static_cast<int>(std::ceil((middle - half) / step - 0.5));
            last = static_cast<int>(std::floor((middle + half) / step - 0.5)) + 1;
        }
        // Angles start at 0: what lies before comes round again at the end.
        if (first < 0) {
            if (last <= 0) return put(first + grid.directions, last + grid.directions);
            put(first + grid.directions, grid.directions);
            first = 0;
        }
        if (last > grid.directions) {
            put(0, last - grid.directions);
            last = grid.directions;
        }
        put(first, last);
    };
    for (std::size_t k = 1; k < around.surface.size(); ++k) add(around.surface[k]);
    for (const Member& j : around.crease) add(j);
}

}  // namespace surflux
