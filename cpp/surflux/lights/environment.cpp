#include "surflux/lights/environment.h"

#include <algorithm>
#include <cmath>

namespace surflux {

namespace {

// The cell of a cumulative distribution that u falls into, and where in the cell it falls, in [0, 1).
std::size_t find_cell(const double* up_to, std::size_t count, double u, double& within) {
    const double* found = std::upper_bound(up_to, up_to + count - 1, u);
    const double below = found == up_to ? 0.0 : found[-1];
    within = *found > below ? std::min((u - below) / (*found - below), 1.0 - 1e-12) : 0.5;
    return static_cast<std::size_t>(found - up_to);
}

// How often a pixel is looked at: by the size of its radiance, which may be below 0 in skies made of some harmonics.
double weight(const Rgb& c) { return luminance({std::abs(c.x), std::abs(c.y), std::abs(c.z)}); }

}  // namespace

EnvironmentMap::EnvironmentMap(const Environment& environment) : environment_(environment) {
    // The shortest rotation of +z onto `up`, applied to +x and +y (Rodrigues); a half turn around +x for up = -z.
    const Vec3& up = environment.up;
    Vec3 middle{1, 0, 0}, left{0, -1, 0};
    if (up.z >= -1.0 + 1e-12) {
        const double k = 1.0 / (1.0 + up.z);
        middle = {1.0 - up.x * up.x * k, -up.x * up.y * k, -up.x};
        left = {-up.x * up.y * k, 1.0 - up.y * up.y * k, -up.y};
    }
    // Quarter turns are exact, so that the pixels' borders stay where they are along the axes.
    const double turned = environment.azimuth - 360.0 * std::floor(environment.azimuth / 360.0);
    const double quarters = std::floor(turned / 90.0), rest = (turned - 90.0 * quarters) * pi / 180.0;
    const Vec3 x = std::cos(rest) * middle + std::sin(rest) * left;
    const Vec3 y = std::cos(rest) * left - std::sin(rest) * middle;
    const Vec3 around[] = {x, y, -x, -y, x};
    const auto quarter = static_cast<std::size_t>(quarters) % 4;
    axis_u_ = -around[quarter];
    axis_v_ = around[quarter + 1];
    if (is_constant()) return;
    const std::size_t w = environment.width, h = environment.height;
    row_up_to_.resize(h);
    pixel_up_to_.resize(w * h);
    double total = 0.0;
    for (std::size_t row = 0; row < h; ++row) {
        const double solid_angle = std::cos(pi * static_cast<double>(row) / static_cast<double>(h)) -
                                   std::cos(pi * static_cast<double>(row + 1) / static_cast<double>(h));
        double sum = 0.0;
        for (std::size_t col = 0; col < w; ++col)
            pixel_up_to_[row * w + col] = sum += weight(environment.pixels[row * w + col]);
        for (std::size_t col = 0; col < w; ++col)
            pixel_up_to_[row * w + col] =
                sum > 0.0 ? pixel_up_to_[row * w + col] / sum : static_cast<double>(col + 1) / static_cast<double>(w);
        row_up_to_[row] = total += sum * solid_angle;
    }
    for (std::size_t row = 0; row < h; ++row)
        row_up_to_[row] = total > 0.0 ? row_up_to_[row] / total : static_cast<double>(row + 1) / static_cast<double>(h);
}

Vec3 EnvironmentMap::to_world(const Vec3& local) const {
    return local.x * axis_u_ + local.y * axis_v_ + local.z * environment_.up;
}

Vec3 EnvironmentMap::to_local(const Vec3& world) const {
    return {dot(world, axis_u_), dot(world, axis_v_), dot(world, environment_.up)};
}

std::size_t EnvironmentMap::pixel_of(const Vec3& local) const {
    const auto w = static_cast<double>(environment_.width), h = static_cast<double>(environment_.height);
    const double theta = std::acos(std::clamp(local.z, -1.0, 1.0));
    double angle = std::atan2(local.y, local.x);
    if (angle < 0.0) angle += 2.0 * pi;
    const auto row = static_cast<std::size_t>(std::min(theta / pi * h, h - 1.0));
    const auto col = static_cast<std::size_t>(std::min(angle / (2.0 * pi) * w, w - 1.0));
    return row * environment_.width + col;
}

Rgb EnvironmentMap::radiance(const Vec3& direction) const {
    return is_constant() ? environment_.radiance : environment_.pixels[pixel_of(to_local(direction))];
}

Vec3 EnvironmentMap::sample(double s, double t) const {
    const std::size_t w = environment_.width, h = environment_.height;
    double within_row, within_col;
    const std::size_t row = find_cell(row_up_to_.data(), h, s, within_row);
    const std::size_t col = find_cell(pixel_up_to_.data() + row * w, w, t, within_col);
    const double top = std::cos(pi * static_cast<double>(row) / static_cast<double>(h));
    const double bottom = std::cos(pi * static_cast<double>(row + 1) / static_cast<double>(h));
    const double z = top + within_row * (bottom - top);
    const double angle = 2.0 * pi * (static_cast<double>(col) + within_col) / static_cast<double>(w);
    const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
    return to_world({r * std::cos(angle), r * std::sin(angle), z});
}

double EnvironmentMap::density(const Vec3& direction) const {
    const std::size_t w = environment_.width, h = environment_.height;
    const std::size_t pixel = pixel_of(to_local(direction));
    const std::size_t row = pixel / w, col = pixel % w;
    const double solid_angle = (std::cos(pi * static_cast<double>(row) / static_cast<double>(h)) -
                                std::cos(pi * static_cast<double>(row + 1) / static_cast<double>(h))) *
                               2.0 * pi / static_cast<double>(w);
    const double row_share = row_up_to_[row] - (row == 0 ? 0.0 : row_up_to_[row - 1]);
    const double col_share = pixel_up_to_[pixel] - (col == 0 ? 0.0 : pixel_up_to_[pixel - 1]);
    return row_share * col_share / solid_angle;
}

}  // namespace surflux
