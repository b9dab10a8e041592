#include "surflux/render/mip_map.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"

namespace surflux {

namespace {

constexpr double most = 65535.0;
constexpr double most_places = 16.0;  // along the longer side of a parallelogram

// `from` texels of a row in `to` equal parts, of which some may have a share of a texel.
struct Halving {
    std::size_t from, to;

    // Calls visit(part, texel, share) for what each part is made of.
    template <class Visit>
    void for_parts(const Visit& visit) const {
        const double step = static_cast<double>(from) / static_cast<double>(to);
        for (std::size_t part = 0; part < to; ++part) {
            const double begin = static_cast<double>(part) * step, end = begin + step;
            for (auto k = static_cast<std::size_t>(begin); k < from && static_cast<double>(k) < end; ++k) {
                const double inside =
                    std::min(end, static_cast<double>(k + 1)) - std::max(begin, static_cast<double>(k));
                if (inside > 1e-9) visit(part, k, static_cast<float>(inside / step));
            }
        }
    }
};

std::vector<float> halved(const std::vector<float>& texels, std::size_t width, std::size_t height, std::size_t channels,
                          std::size_t to_width, std::size_t to_height) {
    std::vector<float> rows(to_height * width * channels, 0.0f);
    Halving{height, to_height}.for_parts([&](std::size_t part, std::size_t k, float share) {
        const float* from = &texels[k * width * channels];
        float* to = &rows[part * width * channels];
        for (std::size_t i = 0; i < width * channels; ++i) to[i] += share * from[i];
    });
    std::vector<float> out(to_height * to_width * channels, 0.0f);
    Halving{width, to_width}.for_parts([&](std::size_t part, std::size_t k, float share) {
        for (std::size_t row = 0; row < to_height; ++row)
            for (std::size_t c = 0; c < channels; ++c)
                out[(row * to_width + part) * channels + c] += share * rows[(row * width + k) * channels + c];
    });
    return out;
}

}  // namespace

MipMap::MipMap(std::vector<float> texels, std::size_t width, std::size_t height, std::size_t channels)
    : channels_(channels) {
    require(width > 0 && height > 0 && channels > 0 && texels.size() == width * height * channels,
            "texels: wanted some, ", channels, " values each, got ", texels.size(), " of ", width, " x ", height);
    add_level(texels, width, height);
    while (width > 1 || height > 1) {
        const std::size_t to_width = std::max<std::size_t>(1, width / 2),
                          to_height = std::max<std::size_t>(1, height / 2);
        texels = halved(texels, width, height, channels, to_width, to_height);
        width = to_width, height = to_height;
        add_level(texels, width, height);
    }
}

void MipMap::add_level(const std::vector<float>& texels, std::size_t width, std::size_t height) {
    Level level{width, height, {}};
    level.roots.reserve(texels.size());
    for (const float value : texels)
        level.roots.push_back(static_cast<std::uint16_t>(
            std::lround(most * std::sqrt(std::clamp(static_cast<double>(value), 0.0, 1.0)))));
    levels_.push_back(std::move(level));
}

void MipMap::mean(const TexturePlace& middle, const TexturePlace& side, const TexturePlace& other, double* out) const {
    const auto width = static_cast<double>(levels_[0].width), height = static_cast<double>(levels_[0].height);
    TexturePlace along = side;
    double longer = std::hypot(side.u * width, side.v * height);
    if (const double length = std::hypot(other.u * width, other.v * height); length > longer)
        longer = length, along = other;
    const double area = std::abs(side.u * other.v - side.v * other.u) * width * height;
    const double shorter = longer > 0.0 ? area / longer : 0.0;  // across the longer one
    const double places = std::clamp(std::round(longer / std::max(shorter, 1.0)), 1.0, most_places);
    const double step = std::max({shorter, longer / places, 1.0});
    const double level = std::min(std::log2(step), static_cast<double>(levels_.size() - 1));
    const auto fine = static_cast<std::size_t>(level);
    const double coarse_share = level - static_cast<double>(fine);
    std::fill_n(out, channels_, 0.0);
    for (int k = 0; k < static_cast<int>(places); ++k) {
        const double t = (k + 0.5) / places - 0.5;
        const TexturePlace at{middle.u + t * along.u, middle.v + t * along.v};
        add_bilinear(levels_[fine], at, (1.0 - coarse_share) / places, out);
        if (coarse_share > 0.0) add_bilinear(levels_[fine + 1], at, coarse_share / places, out);
    }
}

void MipMap::add_bilinear(const Level& level, const TexturePlace& at, double weight, double* sums) const {
    const auto split = [](double place, std::size_t size, std::size_t& first, std::size_t& second) {
        const double x = (place - std::floor(place)) * static_cast<double>(size) - 0.5, whole = std::floor(x);
        first = static_cast<std::size_t>(whole + static_cast<double>(size)) % size;
        second = (first + 1) % size;
        return x - whole;
    };
    std::size_t x[2], y[2];
    const double s = split(at.u, level.width, x[0], x[1]), t = split(at.v, level.height, y[0], y[1]);
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
            const double share = weight * (i == 0 ? 1.0 - s : s) * (j == 0 ? 1.0 - t : t) / (most * most);
            const std::uint16_t* root = &level.roots[(y[j] * level.width + x[i]) * channels_];
            for (std::size_t c = 0; c < channels_; ++c)
                sums[c] += share * static_cast<double>(root[c]) * static_cast<double>(root[c]);
        }
}

std::size_t MipMap::bytes() const {
    std::size_t sum = 0;
    for (const Level& level : levels_) sum += level.roots.size() * sizeof(std::uint16_t);
    return sum;
}

}  // namespace surflux
