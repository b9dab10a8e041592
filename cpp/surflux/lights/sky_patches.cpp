#include "surflux/lights/sky_patches.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/environment.h"

namespace surflux {

namespace {

constexpr int tregenza_rows[] = {30, 30, 24, 24, 18, 12, 6};  // patches in each, from the horizon up

Vec3 direction_at(double altitude_sine, double azimuth) {
    const double r = std::sqrt(std::max(0.0, 1.0 - altitude_sine * altitude_sine));
    return {r * std::sin(azimuth), r * std::cos(azimuth), altitude_sine};
}

}  // namespace

SkyPatches::SkyPatches(int subdivision) {
    require(subdivision >= 1 && subdivision <= 8, "subdivision: wanted 1 to 8 rows of each of Tregenza's, got ",
            subdivision);
    const int rows = 7 * subdivision;
    height_ = 0.5 * pi / (rows + 0.5);
    directions_.push_back({0, 0, -1});
    solid_angles_.push_back(2.0 * pi);
    for (int row = 0; row < rows; ++row) {
        first_.push_back(directions_.size());
        const int count = tregenza_rows[row / subdivision] * subdivision;
        const double low = std::sin(height_ * row), high = std::sin(height_ * (row + 1));
        for (int k = 0; k < count; ++k) {
            directions_.push_back(direction_at(std::sin(height_ * (row + 0.5)), 2.0 * pi * k / count));
            solid_angles_.push_back(2.0 * pi * (high - low) / count);
        }
    }
    first_.push_back(directions_.size());
    directions_.push_back({0, 0, 1});
    solid_angles_.push_back(2.0 * pi * (1.0 - std::cos(0.5 * height_)));
}

std::size_t SkyPatches::index_of(const Vec3& direction) const {
    const double level = std::hypot(direction.x, direction.y);
    if (direction.z < 0.0) return 0;
    const std::size_t rows = first_.size() - 1;
    const auto row = static_cast<std::size_t>(std::atan2(direction.z, level) / height_);
    if (row >= rows) return first_[rows];
    const std::size_t count = first_[row + 1] - first_[row];
    const double turn = std::atan2(direction.x, direction.y) / (2.0 * pi);  // in (-.5, .5]
    const auto k = static_cast<std::size_t>(std::floor((turn + 1.0) * static_cast<double>(count) + 0.5));
    return first_[row] + k % count;
}

std::size_t SkyPatches::row_of(std::size_t patch) const {
    return static_cast<std::size_t>(std::upper_bound(first_.begin(), first_.end(), patch) - first_.begin()) - 1;
}

Vec3 SkyPatches::place_in(std::size_t patch, double u, double v) const {
    const double around = 2.0 * pi * u;
    if (patch == 0) return direction_at(-1.0 + v, around);
    if (patch + 1 == size()) return direction_at(1.0 - v * (1.0 - std::cos(0.5 * height_)), around);
    const std::size_t row = row_of(patch);
    const auto count = static_cast<double>(first_[row + 1] - first_[row]);
    const double low = std::sin(height_ * static_cast<double>(row));
    const double high = std::sin(height_ * static_cast<double>(row + 1));
    return direction_at(low + v * (high - low),
                        2.0 * pi * (static_cast<double>(patch - first_[row]) + u - 0.5) / count);
}

std::vector<Rgb> patch_radiances(const Environment& environment, const SkyPatches& patches) {
    if (environment.pixels.empty()) return std::vector<Rgb>(patches.size(), environment.radiance);
    const std::size_t w = environment.width, h = environment.height;
    // By the zenith's cap, which is half as high as a row.
    const double widest = 0.125 * std::acos(1.0 - patches.solid_angles().back() / (2.0 * pi));
    const auto parts = [&](double angle) { return static_cast<std::size_t>(std::ceil(angle / widest)); };
    const std::size_t down = parts(pi / static_cast<double>(h)), across = parts(2.0 * pi / static_cast<double>(w));
    const Frame frame = EnvironmentMap(environment).image_frame();
    std::vector<Rgb> power(patches.size());
    std::vector<double> covered(patches.size(), 0.0);
    const auto rows = static_cast<double>(h * down), columns = static_cast<double>(w * across);
    for (std::size_t i = 0; i < h * down; ++i) {
        const double top = std::cos(pi * static_cast<double>(i) / rows);
        const double bottom = std::cos(pi * static_cast<double>(i + 1) / rows);
        const double z = 0.5 * (top + bottom), r = std::sqrt(std::max(0.0, 1.0 - z * z));
        const double solid_angle = (top - bottom) * 2.0 * pi / columns;
        for (std::size_t j = 0; j < w * across; ++j) {
            const double phi = 2.0 * pi * (static_cast<double>(j) + 0.5) / columns;
            const std::size_t k = patches.index_of(frame.to_world({r * std::cos(phi), r * std::sin(phi), z}));
            power[k] += solid_angle * environment.pixels[i / down * w + j / across];
            covered[k] += solid_angle;
        }
    }
    for (std::size_t k = 0; k < power.size(); ++k) power[k] *= 1.0 / covered[k];
    return power;
}

}  // namespace surflux
