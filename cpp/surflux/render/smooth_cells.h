#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/render/pixel_places.h"

namespace surflux {

// Which pixels see one smooth surface, and cells of them: what holds at one pixel of a cell probably holds at all.
// Cells lie in squares of `side` pixels, and end where a surface does. Each has a probe, a pixel somewhere in it, from
// square to square in another row and column: a line is found wherever it goes.
class SmoothCells {
public:
    static constexpr std::uint32_t none = 0xffffffffu;

    // A side of 1: all pixels are probes.
    SmoothCells(const PixelPlaces& places, std::size_t side);

    std::uint32_t cell(std::size_t pixel) const { return cell_[pixel]; }  // none where nothing is seen
    const std::vector<std::uint32_t>& probes() const { return probes_; }  // the pixel of each cell
    bool is_each_pixel() const { return side_ == 1; }
    std::size_t bytes() const { return joins_.size() + (cell_.size() + probes_.size()) * sizeof(std::uint32_t); }

    // visit(neighbour) for the up to four pixels beside one that see the same surface.
    template <class Visit>
    void for_neighbors(std::size_t pixel, const Visit& visit) const {
        if (joins_[pixel] & right) visit(pixel + 1);
        if (joins_[pixel] & below) visit(pixel + width_);
        if (pixel % width_ > 0 && (joins_[pixel - 1] & right)) visit(pixel - 1);
        if (pixel >= width_ && (joins_[pixel - width_] & below)) visit(pixel - width_);
    }

    // The same for those at its corners, which it is one with by way of a pixel beside both.
    template <class Visit>
    void for_diagonals(std::size_t pixel, const Visit& visit) const {
        const std::size_t x = pixel % width_, above = pixel - width_, under = pixel + width_;
        const auto both = [&](std::size_t p, std::uint8_t one, std::size_t q, std::uint8_t other) {
            return (joins_[p] & one) && (joins_[q] & other);
        };
        if (pixel >= width_ && x > 0 &&
            (both(pixel - 1, right, above - 1, below) || both(above, below, above - 1, right)))
            visit(above - 1);
        if (pixel >= width_ && x + 1 < width_ &&
            (both(pixel, right, above + 1, below) || both(above, below, above, right)))
            visit(above + 1);
        if (under < joins_.size() && x > 0 &&
            (both(pixel - 1, right, pixel - 1, below) || both(pixel, below, under - 1, right)))
            visit(under - 1);
        if (under < joins_.size() && x + 1 < width_ &&
            (both(pixel, right, pixel + 1, below) || both(pixel, below, under, right)))
            visit(under + 1);
    }

private:
    static constexpr std::uint8_t right = 1, below = 2;
    struct Square {
        std::size_t left, top, right, bottom;
        bool has(std::size_t x, std::size_t y) const { return x >= left && x < right && y >= top && y < bottom; }
    };
    bool is_at_border(std::size_t pixel, const PixelPlaces& places) const;
    void add_square(const Square& in, const PixelPlaces& places, std::vector<std::uint32_t>& probes);

    std::size_t width_, side_;
    std::vector<std::uint8_t> joins_;  // of each pixel: which of the next pixels in its row and column it is one with
    std::vector<std::uint32_t> cell_, probes_;
};

}  // namespace surflux
