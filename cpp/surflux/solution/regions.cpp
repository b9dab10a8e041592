#include "surflux/solution/regions.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "surflux/core/morton.h"

namespace surflux {

namespace {

// Which way a normal points mostly: one of the six axes.
int main_direction(const Vec3& n) {
    const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
    if (x >= y && x >= z) return n.x > 0.0 ? 0 : 1;
    if (y >= z) return n.y > 0.0 ? 2 : 3;
    return n.z > 0.0 ? 4 : 5;
}

Rgb size(const Rgb& c) { return {std::abs(c.x), std::abs(c.y), std::abs(c.z)}; }

}  // namespace

Regions::Regions(const Surfels& surfels, const std::vector<Rgb>& irradiance, std::size_t wanted,
                 const Progress& progress, const SelfCheckTuning& tuning)
    : of(surfels.size()) {
    std::vector<std::uint32_t> along_curve[6];
    std::size_t done = 0;
    for (const std::uint32_t i : morton_order(surfels.positions, progress)) {
        along_curve[main_direction(surfels.normals[i])].push_back(i);
        report_some(progress, ++done, surfels.size(), 1 << 20);
    }
    double total = 0.0, area = 0.0;
    for (const double a : surfels.areas) total += a;
    for (const std::vector<std::uint32_t>& order : along_curve)
        for (const std::uint32_t i : order) {
            report_some(progress, --done, surfels.size(), 1 << 20);
            if (i == order.front() || area * static_cast<double>(wanted) >= total) ++count, area = 0.0;
            area += surfels.areas[i];
            of[i] = static_cast<std::uint32_t>(count - 1);
        }
    part_dim(surfels, irradiance, tuning, progress);
    share.resize(count), light.resize(count), reflectance.resize(count);
    std::vector<Rgb> reflected(count);
    for (std::size_t i = 0; i < of.size(); ++i) {
        report_some(progress, i, of.size(), 1 << 20);
        const Rgb lit = surfels.areas[i] * size(irradiance[i]);
        share[of[i]] += surfels.areas[i];
        light[of[i]] += lit;
        reflected[of[i]] += surfels.reflectance[i] * lit;
        reflectance[of[i]] += surfels.areas[i] * surfels.reflectance[i];
    }
    for (std::size_t k = 0; k < count; ++k) {
        for (int c = 0; c < 3; ++c)
            if (light[k][c] > 0.0)
                reflectance[k][c] = reflected[k][c] / light[k][c];
            else if (share[k] > 0.0)
                reflectance[k][c] /= share[k];
        if (share[k] > 0.0) light[k] *= 1.0 / share[k];
        share[k] /= total;
    }
}

void Regions::part_dim(const Surfels& surfels, const std::vector<Rgb>& irradiance, const SelfCheckTuning& tuning,
                       const Progress& progress) {
    const auto brightness = [&](std::size_t i) {
        const Rgb all = size(irradiance[i]);
        return all.x + all.y + all.z;
    };
    std::vector<double> area(count), light_of(count), dim_area(count);
    const auto is_dim = [&](std::size_t i) {
        return brightness(i) * area[of[i]] < tuning.dim_region * light_of[of[i]];
    };
    for (std::size_t i = 0; i < of.size(); ++i) {
        report_some(progress, i, of.size(), 1 << 20);
        area[of[i]] += surfels.areas[i], light_of[of[i]] += surfels.areas[i] * brightness(i);
    }
    for (std::size_t i = 0; i < of.size(); ++i) {
        report_some(progress, i, of.size(), 1 << 20);
        if (is_dim(i)) dim_area[of[i]] += surfels.areas[i];
    }
    whole.resize(count);
    std::iota(whole.begin(), whole.end(), 0u);
    std::vector<std::uint32_t> own = whole;
    for (std::uint32_t k = 0; k < own.size(); ++k)
        if (area[k] > 0.0 && std::min(dim_area[k], area[k] - dim_area[k]) >= tuning.least_dim_part * area[k]) {
            own[k] = static_cast<std::uint32_t>(count++);
            whole.push_back(k);
        }
    for (std::size_t i = 0; i < of.size(); ++i)
        if (is_dim(i)) of[i] = own[of[i]];
}

Rgb Regions::shape(std::size_t region, const Rgb& irradiance) const {
    Rgb out{1, 1, 1};
    for (int c = 0; c < 3; ++c)
        if (light[region][c] > 0.0) out[c] = std::abs(irradiance[c]) / light[region][c];
    return out;
}

}  // namespace surflux
