#include <algorithm>
#include <cmath>

#include "surflux/core/sampling.h"
#include "surflux/lights/sky_cells.h"

namespace surflux {

// Points of the unit square on their way down a tree of the sky, all of them level by level. Which half each is in is
// anybody's guess to the processor: so halves are counted with and nothing branches on them, divisions of one point
// need not wait for those of another, and what is far in memory is asked for ahead.
class SkyCells::Warp {
public:
    static constexpr std::size_t most = 64;

    Warp(const SkyCells& sky, std::size_t tree, const std::vector<Part>& parts)
        : tree_(sky.trees_[tree]), image_(sky.images_[tree_.image]), parts_(parts) {}

    void sample(const UnitPoint* at, std::size_t count, Sample* out) {
        for (std::size_t i = 0; i < count; ++i) {
            at_[i][0] = at[i].u, at_[i][1] = at[i].v;
            part_[i] = 0;
        }
        find_cells(count);
        find_pixels(count);
        for (std::size_t i = 0; i < count; ++i) out[i] = sample_of(i);
    }

private:
    // The half that t is in, 0 or 1, by the share of the first; t becomes the share in that.
    static std::uint32_t step(double& t, double of_first) {
        const auto half = static_cast<std::uint32_t>(!(t < of_first));
        const auto second = static_cast<double>(half);
        const double share = (t - second * of_first) / std::abs(second - of_first);
        t = std::min(std::max(share, 0.0), 1.0 - 0x1p-53);
        return half;
    }
    static std::uint32_t either(std::uint32_t half, std::uint32_t of_first, std::uint32_t of_second) {
        return of_first + half * (of_second - of_first);
    }

    void find_cells(std::size_t count) {
        std::size_t left = 0;
        for (std::size_t i = 0; i < count; ++i)
            if (parts_[0].second != 0) on_way_[left++] = static_cast<std::uint32_t>(i);
        while (left > 0) {
            const std::size_t before = left;
            left = 0;
            for (std::size_t k = 0; k < before; ++k) {
                const std::uint32_t i = on_way_[k];
                const Part& part = parts_[part_[i]];
                const std::uint32_t half = step(at_[i][part.axis], static_cast<double>(part.of_first));
                const std::uint32_t next = either(half, part_[i] + 1, part.second);
                part_[i] = next;
                on_way_[left] = i;
                left += parts_[next].second != 0;
            }
        }
        for (std::size_t i = 0; i < count; ++i) __builtin_prefetch(&tree_.blocks[parts_[part_[i]].node]);
    }

    void find_pixels(std::size_t count) {
        std::size_t left = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const Block& block = tree_.blocks[parts_[part_[i]].node];
            pixel_[i] = block;
            if (block.is_pixel()) continue;
            power_[i] = image_.power(block);
            on_way_[left++] = static_cast<std::uint32_t>(i);
        }
        while (left > 0) {
            const std::size_t before = left;
            left = 0;
            for (std::size_t k = 0; k < before; ++k) {
                const std::uint32_t i = on_way_[k];
                Pixels b = pixel_[i];
                // Across the side of more pixels: within a cell both are about as wide.
                const auto axis = static_cast<std::uint32_t>(b.bottom - b.top < b.right - b.left);
                const std::uint32_t row = either(axis, (b.top + b.bottom) / 2, b.bottom),
                                    column = either(axis, b.right, (b.left + b.right) / 2);
                const double of_first = image_.power({b.top, row, b.left, column});
                const std::uint32_t half = step(at_[i][axis], std::min(std::max(of_first / power_[i], 0.0), 1.0));
                const double powers[2] = {of_first, power_[i] - of_first};
                power_[i] = powers[half];
                const std::uint32_t lower = half * (1 - axis), right = half * axis;
                b = {either(lower, b.top, row), either(lower, row, b.bottom), either(right, b.left, column),
                     either(right, column, b.right)};
                pixel_[i] = b;
                on_way_[left] = i;
                left += !b.is_one();
            }
        }
        for (std::size_t i = 0; i < count; ++i) __builtin_prefetch(&radiance(pixel_[i]));
    }

    const Rgb& radiance(const Pixels& pixel) const { return image_.pixels[pixel.top * image_.width + pixel.left]; }

    Sample sample_of(std::size_t i) const {
        const Part& part = parts_[part_[i]];
        const Pixels& pixel = pixel_[i];
        Block b = tree_.blocks[part.node];
        if (!b.is_pixel()) {
            const auto azimuth = [&](std::uint32_t column) {
                return 2.0 * pi * static_cast<double>(column) / static_cast<double>(image_.width);
            };
            b.high = image_.heights[pixel.top];
            b.low = image_.heights[pixel.bottom];
            b.from = azimuth(pixel.left);
            b.to = azimuth(pixel.right);
        }
        const double z = b.high + at_[i][0] * (b.low - b.high), around = b.from + at_[i][1] * (b.to - b.from);
        const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
        const Rgb& color = radiance(pixel);
        // 0 where sums that were rounded led to a black one.
        const double brightness = luminance({std::abs(color.x), std::abs(color.y), std::abs(color.z)});
        return {r * std::cos(around) * image_.u + r * std::sin(around) * image_.v + z * image_.n,
                static_cast<double>(part.cosine), brightness > 0.0 ? color / brightness : Rgb{}};
    }

    const Tree& tree_;
    const Image& image_;
    const std::vector<Part>& parts_;
    double at_[most][2], power_[most];
    std::uint32_t part_[most], on_way_[most];
    Pixels pixel_[most];
};

void SkyCells::sample(std::size_t tree, const std::vector<Part>& parts, const std::vector<UnitPoint>& at,
                      std::vector<Sample>& out) const {
    out.resize(at.size());
    Warp warp(*this, tree, parts);
    for (std::size_t begin = 0; begin < at.size(); begin += Warp::most)
        warp.sample(at.data() + begin, std::min(Warp::most, at.size() - begin), out.data() + begin);
}

}  // namespace surflux
