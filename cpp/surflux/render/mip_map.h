#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace surflux {

// A place on a texture, 1 across all of it; v goes down as rows do.
struct TexturePlace {
    double u = 0.0, v = 0.0;
};

// A texture of linear values from 0 to 1 that repeats itself, and its means over more and more texels (Williams 1983),
// of half as many each way from level to level.
class MipMap {
public:
    // texels: rows from the top, `channels` values each. Throws ArgumentError.
    MipMap(std::vector<float> texels, std::size_t width, std::size_t height, std::size_t channels);

    // The means over the parallelogram of two sides around a place: trilinear, at several places along the longer side
    // (McCormack and others 1999), so that what is seen at a slant is not blurred across.
    void mean(const TexturePlace& middle, const TexturePlace& side, const TexturePlace& other, double* out) const;

    std::size_t channels() const { return channels_; }
    std::size_t bytes() const;

private:
    // Square roots, in 65535ths: dark values keep three digits.
    struct Level {
        std::size_t width, height;
        std::vector<std::uint16_t> roots;
    };
    void add_level(const std::vector<float>& texels, std::size_t width, std::size_t height);
    void add_bilinear(const Level& level, const TexturePlace& at, double weight, double* sums) const;

    std::size_t channels_;
    std::vector<Level> levels_;
};

}  // namespace surflux
