#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "surflux/core/parallel.h"
#include "surflux/render/flat_field.h"
#include "surflux/render/pixel_light.h"
#include "surflux/render/seen_lamps.h"
#include "surflux/transfer/local_transfer.h"

namespace surflux {

struct LampViewOptions {
    int samples = 1;      // samples x samples subpixels, averaged
    bool culling = true;  // else surfaces are seen from behind, too, in the light of their fronts
    std::size_t shadow_cell =
        4;  // subpixels a side that a shadow ray speaks for where its neighbours agree; 1: for one
};

struct LampFrameOptions {
    RelightOptions relight;
    PixelLightOptions light;
    bool parts = false;  // direct and indirect light, too
};

// A picture of a scene under lamps: radiance, 3 per pixel, rows from the top, black where nothing is seen. Direct and
// indirect make the whole.
struct LampFrame {
    std::vector<float> radiance, direct, indirect;
    std::vector<float> coverage;  // share of the subpixels that see a surface or a lamp
    std::size_t shadow_rays = 0;  // of the picture, beside those of indirect light
    Figures timings;
};

// What a picture shows besides light, rows from the top.
struct LampSurfaces {
    std::vector<float> albedo;  // 3 per pixel: the mean of its subpixels, 0 where no surfel is seen
    // Of one subpixel, the middle one (the one right below the middle for even `samples`):
    std::vector<float> normal;        // 3 per pixel, of the side that is seen; 0 where nothing is
    std::vector<float> depth;         // along the view axis; infinity where nothing is seen
    std::vector<std::int32_t> index;  // of the surfel seen, -1 where nothing is, -2 - k for area light number k
};

// A scene under lamps that move, seen from one place (L07 section 6.5): indirect light by transfer, drawn as flat
// values, direct light found at every pixel. What does not depend on lamps is kept from picture to picture: what each
// pixel sees, what of the field it shows, and where the surface is smooth.
class LampView {
public:
    // Transfer must outlive it. Throws ArgumentError, and DeviceError where there are disks and no OpenGL.
    LampView(const LocalTransfer& transfer, const PatchCorners& corners, const Camera& camera, std::size_t width,
             std::size_t height, const LampViewOptions& options = {}, gl::Api api = gl::requested_api());

    // reflectance: of each surfel, or empty for the scene's. The same for any number of threads, of which several may
    // draw at once.
    LampFrame frame(const std::vector<Light>& lights, const std::vector<Rgb>& reflectance,
                    const LampFrameOptions& options = {}) const;

    std::size_t width() const { return places_.rays.width / samples_; }
    std::size_t height() const { return places_.rays.height / samples_; }
    // What subpixels see, rows from the top.
    const PixelPlaces& places() const { return places_; }
    // Of subpixels of the scene's own colours, others: 3 values each, by subpixel, where `painted` is not 0.
    void paint(const std::vector<char>& painted, const std::vector<float>& reflectance,
               const std::vector<float>& emission);
    LampSurfaces surfaces(const std::vector<Light>& lights, const std::vector<Rgb>& reflectance) const;
    std::size_t bytes() const;
    const Figures& timings() const { return timings_; }  // of how it was made

private:
    struct Work {
        PixelLight::Scratch light;
        std::vector<float> direct, albedo;
        std::vector<FlatField::Value> indirect;  // at nodes
        SeenLamps lamps;
    };
    template <class Values>
    void put_seen(const Values& of_surfels, std::vector<float>& out) const;
    void compose(const std::vector<Light>& lights, const std::vector<float>& albedo, const Work& work,
                 const LampFrameOptions& options, LampFrame& out) const;
    // Number k of the subpixels of a pixel, row by row.
    std::size_t subpixel(std::size_t pixel, std::size_t k) const {
        const std::size_t x = pixel % width(), y = pixel / width();
        return (y * samples_ + k / samples_) * places_.rays.width + x * samples_ + k % samples_;
    }

    const LocalTransfer& transfer_;
    const std::size_t samples_;
    Figures timings_;
    PixelPlaces places_;
    FlatField field_;
    std::unique_ptr<const SmoothCells> cells_;
    std::vector<float> albedo_, emission_;  // by subpixel, 3 each; emission_ is empty where nothing shines
    mutable Scratch<Work> work_;
};

}  // namespace surflux
