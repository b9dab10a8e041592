#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/gl/context.h"
#include "surflux/render/camera.h"
#include "surflux/render/splat.h"
#include "surflux/render/visible_emitter.h"
#include "surflux/scene/surfels.h"

namespace surflux {

// A splat image as a matrix: what surfels and emitters each add to a pixel. While camera and geometry
// stay, a picture of other values is one product, and what OpenGL did is done once (L07 section 6.2 says that the
// hierarchy can be flattened for drawing).
class FlatImage {
public:
    // values: of each surfel; emitters: of each emitter. Rows from the top, 3 numbers a pixel.
    // Throws ArgumentError for another number of them, or values that are not finite.
    std::vector<float> draw(const std::vector<Rgb>& values, const std::vector<Rgb>& emitters) const;

    // Of each pixel, the share of its subpixels that see a surface or an emitter: what its weights make.
    const std::vector<float>& coverage() const { return coverage_; }

    // visit(column, weight) of what makes a pixel: surfels, then emitters, numbered in a row.
    template <class Visit>
    void for_pixel(std::size_t pixel, const Visit& visit) const {
        for (std::uint64_t e = begin_[pixel]; e < begin_[pixel + 1]; ++e) visit(columns_[e], weights_[e]);
    }

    std::size_t width() const { return width_; }
    std::size_t height() const { return height_; }
    std::size_t entries() const { return columns_.size(); }
    std::size_t bytes() const;

private:
    friend FlatImage flat_image(const Surfels&, const std::vector<VisibleEmitter>&, const Camera&, std::size_t,
                                std::size_t, const SplatOptions&, gl::Api);

    std::size_t width_ = 0, height_ = 0;
    std::size_t surfels_ = 0, emitters_ = 0;
    std::vector<std::uint64_t> begin_;    // of each pixel, and the end of the last
    std::vector<std::uint32_t> columns_;  // surfels, then emitters
    std::vector<float> weights_;
    std::vector<float> coverage_;
};

// What splat_image draws, to the precision of float32. All rows of the image: options.rows is ignored.
// Throws ArgumentError, and DeviceError where there is no GL.
FlatImage flat_image(const Surfels& surfels, const std::vector<VisibleEmitter>& emitters, const Camera& camera,
                     std::size_t width, std::size_t height, const SplatOptions& options = {},
                     gl::Api api = gl::requested_api());

}  // namespace surflux
