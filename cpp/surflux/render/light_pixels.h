#pragma once

#include <cstddef>
#include <vector>

#include "surflux/render/seen_supports.h"

namespace surflux {

// Where the light of a picture of subpixels is evaluated: once for those of a pixel that see one smooth piece of a
// surface, in the middle of them, and anew for each other; and for each where light changes fast from pixel to pixel,
// or may change within one. Colours, edges and depths are of subpixels still.
class LightPixels {
public:
    // places, normals: by subpixel, 4 numbers each: place and object (below 0: nothing), and normal. depths: 4 numbers
    // each, of which the first counts. samples: subpixels a side of a pixel, which width and height are multiples of;
    // pixel: its height at depth 1.
    LightPixels(const std::vector<float>& places, const std::vector<float>& normals, const std::vector<float>& depths,
                int width, int height, int samples, float pixel);
    // Those subpixels that have light of their own, as pixels; of others nothing is seen. places and so on as before.
    LightPixels alone(const std::vector<float>& places, const std::vector<float>& normals,
                      const std::vector<float>& depths) const;

    int width() const { return static_cast<int>(width_); }  // pixels
    int height() const { return static_cast<int>(height_); }
    // By pixel, as of subpixels.
    const std::vector<float>& places() const { return places_; }
    const std::vector<float>& normals() const { return normals_; }
    // Of the farthest of them; 0 where nothing is seen.
    const std::vector<float>& depths() const { return depths_; }

    // light: of pixels, 4 numbers each, of which 3 count.
    void divide_where_uneven(const std::vector<float>& light);
    // Where supports, within which light changes little, are no wider than pixels. Places are relative to the origin,
    // in the camera's frame; view: of the pixels.
    void divide_where_fine(const std::vector<DrawnSupport>& supports, const Vec3& origin, const DrawnView& view);

    std::size_t pixel_of(std::size_t subpixel) const {
        const std::size_t fine = width_ * samples_;
        return subpixel / fine / samples_ * width_ + subpixel % fine / samples_;
    }
    // Has a subpixel light of its own?
    bool is_alone(std::size_t subpixel) const { return alone_[subpixel] != 0; }
    // Of the subpixels that see a surface.
    double share_alone() const;

private:
    std::size_t subpixel(std::size_t pixel, std::size_t k) const {
        const std::size_t y = pixel / width_ * samples_ + k / samples_, x = pixel % width_ * samples_ + k % samples_;
        return y * width_ * samples_ + x;
    }

    void divide(std::size_t pixel) {
        for (std::size_t k = 0; k < samples_ * samples_; ++k) alone_[subpixel(pixel, k)] = 1;
    }

    std::size_t width_, height_, samples_;
    std::vector<float> places_, normals_, depths_;
    std::vector<float> extents_;  // how far a pixel reaches over its piece
    float pixel_, largest_extent_ = 0.0f;
    std::vector<char> seen_, alone_;  // by subpixel
};

}  // namespace surflux
