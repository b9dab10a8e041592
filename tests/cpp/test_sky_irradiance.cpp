#include "surflux/lights/sky_irradiance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shapes.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/environment.h"
#include "surflux/lights/polygon.h"

namespace surflux {
namespace {

using shapes::add_rectangle;
using shapes::finish;
using shapes::scene_of;

const Vec3 up{0, 0, 1};

Environment image_of(std::size_t width, std::size_t height, const Vec3& axis_up = up, double azimuth = 0.0) {
    Environment e;
    e.width = width;
    e.height = height;
    e.up = axis_up;
    e.azimuth = azimuth;
    Random random(4, width);
    for (std::size_t k = 0; k < width * height; ++k)
        e.pixels.push_back({random.uniform(), 2.0 * random.uniform(), k % 3 == 0 ? 0.0 : random.uniform()});
    return e;
}

Surfels floor_of(int n) {
    Surfels s;
    add_rectangle(s, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, n, n);
    finish(s, 0.5, 0.0);
    return s;
}

// What images bring to a plane by an even sum over heights and azimuths.
Rgb summed(const EnvironmentMap& map, const Vec3& normal, std::size_t steps) {
    Rgb sum;
    for (std::size_t i = 0; i < steps; ++i)
        for (std::size_t k = 0; k < 2 * steps; ++k) {
            const double z = 1.0 - 2.0 * (static_cast<double>(i) + 0.5) / static_cast<double>(steps);
            const double azimuth = pi * (static_cast<double>(k) + 0.5) / static_cast<double>(steps);
            const double r = std::sqrt(1.0 - z * z);
            const Vec3 direction{r * std::cos(azimuth), r * std::sin(azimuth), z};
            sum += std::max(0.0, dot(normal, direction)) * map.radiance(direction);
        }
    const auto n = static_cast<double>(steps);
    return (2.0 * pi / (n * n)) * sum;
}

Rgb of_all_trees(const std::vector<Light>& lights, const Vec3& normal,
                 SkyCells::Sources sources = SkyCells::Sources::images) {
    const SkyCells sky(lights, sources);
    Rgb all;
    std::vector<SkyCells::Part> parts;
    for (std::size_t tree = 0; tree < sky.trees(); ++tree) all += sky.find_parts(tree, normal, parts);
    return all;
}

TEST(SkyCells, KnowWhatTheyBringToAnyPlane) {
    for (const std::size_t height : {4, 32}) {
        const Environment e = image_of(2 * height, height, normalized({1, 2, 3}), 37.0);
        const std::vector<Light> lights{e};
        const SkyCells sky(lights);
        const EnvironmentMap map(e);
        for (const Vec3& n : {up, Vec3{0, 0, -1}, normalized({1, -1, 0.2}), normalized({-2, 1, -1})}) {
            const Rgb wanted = summed(map, n, 1500), found = of_all_trees(lights, n);
            // Cells that the horizon crosses are up to 0.06 wide, and their mean cosine is off by a tenth of that.
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], wanted[c], 0.1 * 0.06 * 0.06 * pi * 2.0) << height;
        }
    }
}

TEST(SkyCells, ASkyOfOneColourIsPiTimesItsRadiance) {
    Environment even;
    even.radiance = {1, 2, 3};
    const std::vector<Light> lights{even};
    EXPECT_TRUE(SkyCells(lights).empty());
    Random random(1);
    for (int k = 0; k < 20; ++k) {
        const Vec3 n = normalized({random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5});
        EXPECT_NEAR(of_all_trees(lights, n, SkyCells::Sources::all).z, 3.0 * pi, 1e-12);
    }
}

// Nodes are in floats, radiance is not.
TEST(SkyCells, RadianceMayBeOfAnySize) {
    const Vec3 n = normalized({1, -1, 0.2});
    const Rgb wanted = of_all_trees({image_of(64, 32)}, n);
    for (const double scale : {1e-60, 1e60}) {
        Environment e = image_of(64, 32);
        for (Rgb& pixel : e.pixels) pixel *= scale;
        const std::vector<Light> lights{e};
        const SkyCells sky(lights);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(of_all_trees(lights, n)[c] / scale, wanted[c], 1e-6 * wanted[c]);
        std::vector<SkyCells::Part> parts;
        sky.find_parts(0, n, parts);
        std::vector<SkyCells::UnitPoint> at;
        for (int k = 0; k < 64; ++k) at.push_back({(k + 0.5) / 64, std::fmod(0.618 * k, 1.0)});
        std::vector<SkyCells::Sample> samples;
        sky.sample(0, parts, at, samples);
        for (const SkyCells::Sample& sample : samples) {
            EXPECT_NEAR(length(sample.direction), 1.0, 1e-9);
            EXPECT_NEAR(luminance(sample.color), 1.0, 1e-6);
        }
    }
}

TEST(SkyCells, NarrowSpotsStandAlone) {
    Environment e = image_of(64, 32);
    const std::vector<Light> smooth{e};
    EXPECT_EQ(SkyCells(smooth).trees(), 1u);
    e.pixels[8 * 64 + 5] = {1e6, 1e6, 1e6};
    const std::vector<Light> lights{e};
    const SkyCells sky(lights);
    ASSERT_EQ(sky.trees(), 2u);
    // All that the spot brings, and the rest as without it: the sum is that of the whole.
    const double high = std::cos(pi * 8 / 32), low = std::cos(pi * 9 / 32), middle = 2 * pi * 5.5 / 64;
    std::vector<SkyCells::Part> parts;
    const Vec3 n = normalized({-std::cos(middle), std::sin(middle), 1.0});
    const double r =
        0.5 * (high * std::sqrt(1 - high * high) + std::asin(high) - low * std::sqrt(1 - low * low) - std::asin(low));
    const double across = 2.0 * std::sin(pi / 64);
    const double wanted = 1e6 * (r * across * std::sqrt(0.5) + std::sqrt(0.5) * pi / 64 * (high * high - low * low));
    const Rgb all = of_all_trees(lights, n);
    EXPECT_NEAR(all.x - summed(EnvironmentMap(image_of(64, 32)), n, 1500).x, wanted, 1e-4 * wanted);
    EXPECT_GT(sky.find_parts(0, n, parts).x, 0.9 * wanted);
    EXPECT_LT(sky.find_parts(1, n, parts).x, 10.0);
}

TEST(SkyCells, SamplesAreTheSameHoweverManyAtOnce) {
    const std::vector<Light> lights{image_of(128, 64, normalized({0, 1, 1}))};
    const SkyCells sky(lights);
    std::vector<SkyCells::Part> parts;
    sky.find_parts(0, normalized({0.3, -0.2, 0.9}), parts);
    EvenPoints even(2, 7, 0);
    std::vector<SkyCells::UnitPoint> at;
    for (int k = 0; k < 200; ++k) {
        const double* u = even.next();
        at.push_back({u[0], u[1]});
    }
    std::vector<SkyCells::Sample> all, one;
    sky.sample(0, parts, at, all);
    ASSERT_EQ(all.size(), at.size());
    for (std::size_t k = 0; k < at.size(); ++k) {
        sky.sample(0, parts, {at[k]}, one);
        EXPECT_EQ(all[k].direction, one[0].direction);
        EXPECT_EQ(all[k].mean_cosine, one[0].mean_cosine);
        EXPECT_EQ(all[k].color, one[0].color);
    }
}

TEST(SkyCells, SamplesFallInProportionToWhatCellsBring) {
    Environment e = image_of(16, 8, normalized({0, 1, 1}));
    const std::vector<Light> lights{e};
    const SkyCells sky(lights);
    ASSERT_EQ(sky.trees(), 1u);
    const EnvironmentMap map(e);
    std::vector<SkyCells::Part> parts;
    const Vec3 n = normalized({0.3, -0.2, 0.9});
    const Rgb all = sky.find_parts(0, n, parts);
    EvenPoints even(2, 3, 0);
    constexpr int count = 1 << 14;
    // The density of a direction is its luminance times the mean cosine of its cell, over that of all: so the mean of
    // any function of directions over that density is its integral. Here: radiance times cosine squared.
    Rgb found, wanted;
    std::vector<SkyCells::UnitPoint> at;
    for (int k = 0; k < count; ++k) {
        const double* u = even.next();
        at.push_back({u[0], u[1]});
    }
    std::vector<SkyCells::Sample> samples;
    sky.sample(0, parts, at, samples);
    for (const SkyCells::Sample& sample : samples) {
        const double cosine = std::max(0.0, dot(n, sample.direction));
        const Rgb radiance = map.radiance(sample.direction);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(sample.color[c], radiance[c] / luminance(radiance), 1e-5);
        found += (cosine * cosine * luminance(all) / (count * sample.mean_cosine)) * sample.color;
    }
    constexpr int steps = 1000;
    for (int i = 0; i < steps; ++i)
        for (int k = 0; k < 2 * steps; ++k) {
            const double z = 1.0 - 2.0 * (i + 0.5) / steps, azimuth = pi * (k + 0.5) / steps,
                         r = std::sqrt(1.0 - z * z);
            const Vec3 direction{r * std::cos(azimuth), r * std::sin(azimuth), z};
            const double cosine = std::max(0.0, dot(n, direction));
            wanted += (2.0 * pi / (1.0 * steps * steps) * cosine * cosine) * map.radiance(direction);
        }
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], wanted[c], 0.01 * wanted[c]);
}

// At places on a floor, with and without a screen beside them.
std::vector<SkyLight> on_floor(const Scene& scene, const std::vector<Vec3>& points, int rays, std::uint64_t seed = 0) {
    const Tracer tracer(scene);
    std::vector<Place> places;
    for (const Vec3& p : points) places.push_back({p, up, tracer.departure(p, up).surfel});
    return sky_irradiance(tracer, SkyCells(scene.lights), SurfelPoints(scene.surfels), places, rays, seed);
}

Surfels screen() {  // fills all that lies on the side of x > 1, up to 45 degrees seen from the origin
    Surfels s;
    add_rectangle(s, {1, -100, 0}, {0, 200, 0}, {0, 0, 1}, 1, 1);
    finish(s, 0.0, 0.0);
    return s;
}

TEST(SkyIrradiance, IsExactInTheOpen) {
    const Scene scene = scene_of({floor_of(4)}, {image_of(32, 16)});
    const SkyLight found = on_floor(scene, {{0.1, 0.2, 0}}, 8)[0];
    const Rgb all = of_all_trees(scene.lights, up);
    for (int c = 0; c < 3; ++c) EXPECT_EQ(found.irradiance[c], all[c]);
    EXPECT_EQ(found.error, 0.0);
}

TEST(SkyIrradiance, BesideAWallIsWhatItsHeightSays) {
    // An even sky over half a plane: a wall without ends that rises to the angle a hides (1 - cos a) / 2 of it.
    Environment e = image_of(32, 16);
    for (Rgb& pixel : e.pixels) pixel = {1, 2, 3};
    const Scene scene = scene_of({floor_of(4), screen()}, {e});
    const double wanted = pi * (0.5 + 0.5 * std::cos(pi / 4));
    double squared[2] = {}, stated = 0.0;
    constexpr int seeds = 32;
    for (int many = 0; many < 2; ++many)
        for (std::uint64_t seed = 0; seed < seeds; ++seed) {
            const SkyLight at = on_floor(scene, {{0, 0.01, 0}}, many ? 1024 : 64, seed)[0];
            const Rgb found = at.irradiance;
            squared[many] += (found.x - wanted) * (found.x - wanted) / seeds;
            if (many == 0) stated += at.error / luminance({1, 2, 3}) / seeds;
            EXPECT_NEAR(found.z, 3.0 * found.x, 1e-5);
        }
    // 16 times as many rays: by n^-3/4 an eighth of the error, at random a quarter.
    EXPECT_LT(std::sqrt(squared[1]), 0.25 * std::sqrt(squared[0]));
    EXPECT_LT(std::sqrt(squared[1]), 0.01 * wanted);
    EXPECT_LT(std::sqrt(squared[0]), 2.0 * stated);
    EXPECT_GT(std::sqrt(squared[0]), 0.25 * stated);
}

TEST(SkyIrradiance, ThroughASlitComesTheColorThatIsSeen) {
    // Rings of 10 degrees around x, red and green by turns; a slit in a ceiling shows part of one, a cell has of both.
    Environment e = image_of(36, 18, {1, 0, 0});
    for (std::size_t k = 0; k < e.pixels.size(); ++k) e.pixels[k] = k / 36 % 2 == 0 ? Rgb{4, 0, 0} : Rgb{0, 1, 0};
    constexpr double left = 0.02, right = 0.15, half = 0.3, far = 1000.0;
    Surfels ceiling;
    add_rectangle(ceiling, {-far, -far, 1}, {0, 2 * far, 0}, {far + left, 0, 0}, 1, 1);
    add_rectangle(ceiling, {right, -far, 1}, {0, 2 * far, 0}, {far - right, 0, 0}, 1, 1);
    add_rectangle(ceiling, {left, -far, 1}, {0, far - half, 0}, {right - left, 0, 0}, 1, 1);
    add_rectangle(ceiling, {left, half, 1}, {0, far - half, 0}, {right - left, 0, 0}, 1, 1);
    finish(ceiling, 0.0, 0.0);
    const Vec3 slit[] = {{left, -half, 1}, {left, half, 1}, {right, half, 1}, {right, -half, 1}};
    const double wanted = 4.0 * pi * element_to_polygon({0, 0, 0}, up, slit, 4);
    const Scene scene = scene_of({floor_of(4), ceiling}, {e});
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
        const Rgb found = on_floor(scene, {{0, 0, 0}}, 4096, seed)[0].irradiance;
        EXPECT_NEAR(found.x, wanted, 0.05 * wanted);
        EXPECT_LT(found.y, 0.001 * wanted);
    }
}

TEST(SkyIrradiance, WhatHidesLessThanOneRayIsNotLost) {
    // As above, from 3 before the wall: it hides .026 of the sky, .8 of 32 rays. The mean of many has no bias.
    Environment e = image_of(32, 16);
    for (Rgb& pixel : e.pixels) pixel = {1, 2, 3};
    const Scene scene = scene_of({floor_of(4), screen()}, {e});
    const double hidden = pi * (0.5 - 0.5 / std::sqrt(1.0 + 1.0 / 9.0));
    constexpr int places = 4000;
    std::vector<Vec3> points;
    for (int k = 0; k < places; ++k) points.push_back({-1.9999, 2.0 * (k + 0.5) / places, 0});
    double mean = 0.0;
    for (const SkyLight& found : on_floor(scene, points, 32)) mean += (pi - found.irradiance.x) / places;
    EXPECT_NEAR(mean, hidden, 0.05 * hidden);
}

TEST(SkyIrradiance, TheSunInAPixelHasShadowsWithSharpEdges) {
    // A pixel of 1.4 degrees at 45 over +x, and a wall that hides it up to 1 before its foot.
    Environment e = image_of(256, 128);
    for (Rgb& pixel : e.pixels) pixel = {0.1, 0.1, 0.1};
    e.pixels[32 * 256 + 127] = {1e6, 1e6, 1e6};
    const Scene scene = scene_of({floor_of(8), screen()}, {e});
    // The pixel lies at angles of 45 to 46.4 degrees from up: its shadow ends within tan of those.
    const double far = 1.0 - std::tan(pi * 33 / 128), near = 1.0 - std::tan(pi * 32 / 128) / std::cos(2 * pi / 256);
    std::vector<Vec3> points;
    for (int k = 0; k < 200; ++k) points.push_back({-0.2 + 0.0019 * k, 0.3, 0});
    const std::vector<SkyLight> found = on_floor(scene, points, 64);
    const double sun = of_all_trees({e}, up).x;
    for (std::size_t k = 0; k < points.size(); ++k) {
        if (points[k].x < far - 1e-3) {
            EXPECT_NEAR(found[k].irradiance.x, sun, 1e-3 * sun) << points[k].x;
        }
        if (points[k].x > near + 1e-3) {
            EXPECT_LT(found[k].irradiance.x, 0.1 * pi) << points[k].x;
            EXPECT_GT(found[k].irradiance.x, 0.05 * pi)
                << points[k].x;  // the rest of the sky is not lost beside the sun
        }
    }
}

TEST(SkyIrradiance, NothingRisesOverAPlaneThatTurnsAway) {
    Environment e = image_of(32, 16);
    for (std::size_t k = 0; k < e.pixels.size() / 2; ++k) e.pixels[k] = {};  // dark above
    const Scene scene = scene_of({floor_of(4)}, {e});
    EXPECT_LT(luminance(on_floor(scene, {{0, 0, 0}}, 64)[0].irradiance), 1e-3);
    EXPECT_TRUE(on_floor(scene_of({floor_of(4)}, {Environment{}}), {{0, 0, 0}}, 64)[0].irradiance == Rgb{});
}

}  // namespace
}  // namespace surflux
