#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace surflux {

// The surfaces that the pixels of an image see, in tiles. L07 6.2 asks by occlusion queries which blocks of a thousand
// functions may be in view; since the pixels' places are there before any function is drawn, this says it of every
// function, and which part of the image is enough for it.
class SeenTiles {
public:
    struct Rectangle {
        int left, top, right, bottom;  // pixels, the last ones not counted in
        bool empty() const { return left >= right || top >= bottom; }
    };

    // By pixel, 4 numbers each: place and object (below 0: nothing), and normal.
    SeenTiles(const std::vector<float>& places, const std::vector<float>& normals, int width, int height);

    // The part of `within` outside of which no pixel sees the object nearer than `radius` to the center and facing a
    // compatible way.
    Rectangle part(const Rectangle& within, const float center[3], float radius, const float normal[3],
                   float object) const;

private:
    static constexpr int side = 16;  // pixels: of the finer ones there are many, coarser ones hold little back
    struct Surface {
        float object;
        float low[3], high[3];  // of places
        float normal_low[3], normal_high[3];
    };
    bool meets(std::size_t tile, const float center[3], float radius, const float normal[3], float object) const;

    int columns_;
    std::vector<std::uint32_t> begin_;  // of each tile in surfaces_
    std::vector<Surface> surfaces_;     // one for each object that a tile sees
};

}  // namespace surflux
