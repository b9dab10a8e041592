#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "splat_pictures.h"
#include "surflux/core/error.h"
#include "surflux/render/bends.h"
#include "surflux/render/screen_bounds.h"

namespace surflux {
namespace {

class SplatFilter : public testing::TestWithParam<gl::Api> {};
INSTANTIATE_TEST_SUITE_P(Apis, SplatFilter, testing::Values(gl::Api::egl, gl::Api::osmesa),
                         [](const auto& test) { return test.param == gl::Api::egl ? "egl" : "osmesa"; });

// A floor of side x side disks at z = 0, a checkerboard of `cells` disks a field.
Surfels floor_of(int side, double size) {
    Surfels s;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j)
            add_disk(s, {size * ((i + 0.5) / side - 0.5), size * (j + 0.5) / side, 0}, {0, 0, 1}, 0.8 * size / side);
    return s;
}

std::vector<Rgb> checkered(const Surfels& s, double field) {
    std::vector<Rgb> out;
    for (const Vec3& p : s.positions) {
        const auto sum = static_cast<long>(std::floor(p.x / field)) + static_cast<long>(std::floor(p.y / field));
        out.push_back(sum % 2 == 0 ? Rgb{1, 1, 1} : Rgb{0, 0, 0});
    }
    return out;
}

double rms(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0.0;
    for (std::size_t k = 0; k < a.size(); ++k)
        sum += std::pow(static_cast<double>(a[k]) - static_cast<double>(b[k]), 2);
    return std::sqrt(sum / static_cast<double>(a.size()));
}

// A checkered floor to the horizon, its fields far smaller than a pixel there: with one sample a pixel it is within 7 %
// of a picture of 16 x 16 samples a pixel, in which nothing is left to filter. Kernels alone, without the filter, make
// noise of black and white: that is what `sharp` holds, a picture as fine of which every 16th pixel is taken.
TEST_P(SplatFilter, ACheckeredFloorDoesNotAliasAtTheHorizon) {
    const Surfels s = floor_of(300, 12.0);
    const std::vector<Rgb> radiance = checkered(s, 0.08);
    const Camera camera{{0, -0.5, 0.5}, {0, 4, 0}, {0, 0, 1}, 40.0};
    const std::size_t side = 64, finer = 16;
    const Picture once = picture(s, radiance, {}, camera, side, side, GetParam());
    SplatOptions many;
    many.samples = static_cast<int>(finer);
    const Picture exact = picture(s, radiance, {}, camera, side, side, GetParam(), many);
    const Picture fine = picture(s, radiance, {}, camera, finer * side, finer * side, GetParam());
    std::vector<float> sharp;
    for (std::size_t y = 0; y < side; ++y)
        for (std::size_t x = 0; x < side; ++x)
            for (std::size_t c = 0; c < 3; ++c)
                sharp.push_back(
                    fine.radiance[3 * ((finer * y + finer / 2) * finer * side + finer * x + finer / 2) + c]);
    EXPECT_LT(rms(once.radiance, exact.radiance), 0.07);
    EXPECT_GT(rms(sharp, exact.radiance), 0.14);
}

// The picture does not flicker as the camera moves by less than a pixel: far off all is grey.
TEST_P(SplatFilter, FarFieldsAreGrey) {
    const Surfels s = floor_of(300, 12.0);
    const std::vector<Rgb> radiance = checkered(s, 0.08);
    for (const double shift : {0.0, 0.011, 0.023}) {
        const Camera camera{{shift, -30, 8}, {shift, 6, 0}, {0, 0, 1}, 12.0};
        const Picture image = picture(s, radiance, {}, camera, 48, 48, GetParam());
        for (std::size_t p = 0; p < image.index.size(); ++p) {
            if (image.index[p] < 0) continue;
            const std::size_t x = p % 48, y = p / 48;
            const bool inside = x > 1 && y > 1 && x < 46 && y < 46 && image.index[p - 98] >= 0 &&
                                image.index[p + 98] >= 0 && image.index[p - 2] >= 0 && image.index[p + 2] >= 0;
            if (inside) {
                ASSERT_NEAR(image.radiance[3 * p], 0.5, 0.16) << x << " " << y << " " << shift;
            }
        }
    }
}

TEST_P(SplatFilter, BacksAreShownWhereTheyAreNotCulled) {
    Surfels s;
    add_disk(s, {-1, 0, 0}, {0, 1, 0}, 0.8);                     // faces away
    add_square(s, {0.2, 0, -0.8}, {0, 0, 1.6}, {1.6, 0, 0}, 3);  // u x v = +y: away
    SplatOptions both;
    both.culling = false;
    const Picture image = picture(s, constant(s, {1, 2, 3}), {}, front, 100, 100, GetParam(), both);
    const double scale = 50.0 / std::tan(30.0 * pi / 180.0) / 4.0;
    const auto at = [&](double x) { return 50 * 100 + static_cast<std::size_t>(50.0 + scale * x); };
    for (const double x : {-1.0, 1.0}) {
        EXPECT_GE(image.index[at(x)], 0);
        EXPECT_LE(std::abs(image.radiance[3 * at(x) + 2] - 3.0f), 1e-5f);
        EXPECT_NEAR(image.normal[3 * at(x) + 1], -1.0f, 1e-6f);  // towards the camera
    }
    EXPECT_EQ(std::count_if(image.index.begin(), image.index.end(), [](int i) { return i == 0; }) > 100, true);
}

// Two disks back to back: the side that faces the camera is the one that is seen, culled or not.
TEST_P(SplatFilter, OfASheetTheNearSideIsSeen) {
    Surfels s;
    add_disk(s, {0, 0, 0}, {0, 1, 0}, 1.0);
    add_disk(s, {0, 0, 0}, {0, -1, 0}, 1.0);
    for (const bool culling : {true, false}) {
        SplatOptions options;
        options.culling = culling;
        const Picture image = picture(s, {{9, 0, 0}, {0, 5, 0}}, {}, front, 40, 40, GetParam(), options);
        EXPECT_EQ(image.radiance[3 * (20 * 40 + 20)], 0.0f);
        EXPECT_EQ(image.radiance[3 * (20 * 40 + 20) + 1], 5.0f);
    }
}

// A ball of few disks: bent along the surface, they end where the ball does. Flat ones stick out by R^2 / 2r.
TEST_P(SplatFilter, TheOutlineOfABallIsRound) {
    const Surfels ball = sphere(500, {0, 0, 0}, 1.0);
    const Picture image = picture(ball, constant(ball, {1, 1, 1}), {}, front, 400, 400, GetParam());
    const double scale = 200.0 / std::tan(30.0 * pi / 180.0), outline = scale / std::sqrt(15.0);  // tan asin(1/4)
    double most = 0.0, least = 1e9, depth_error = 0.0;
    for (std::size_t p = 0; p < image.index.size(); ++p) {
        const double x = static_cast<double>(p % 400) + 0.5 - 200.0, y = static_cast<double>(p / 400) + 0.5 - 200.0;
        const double r = std::hypot(x, y);
        if (image.index[p] < 0) {
            least = std::min(least, r);
            continue;
        }
        most = std::max(most, r);
        if (r > 0.9 * outline) continue;
        // |t (x, scale, y) / scale - (0, 4, 0)| = 1
        const double a = (r * r) / (scale * scale) + 1.0, t = (4.0 - std::sqrt(16.0 - 15.0 * a)) / a;
        depth_error = std::max(depth_error, std::abs(static_cast<double>(image.depth[p]) - t));
    }
    EXPECT_LT(most, outline + 1.0);
    EXPECT_GT(least, outline - 1.0);
    EXPECT_LT(depth_error, 0.003);  // flat: R^2 / 2 = .013
}

// Every pixel of the ball is covered from near and far, and from inside of none.
TEST_P(SplatFilter, ABallHasNoHoles) {
    const Surfels ball = sphere(800, {0, 0, 0}, 1.0);
    for (const double distance : {1.3, 2.0, 6.0, 40.0}) {
        const Camera camera{{0, -distance, 0}, {0, 0, 0}, {0, 0, 1}, 60.0};
        const Picture image = picture(ball, constant(ball, {1, 1, 1}), {}, camera, 120, 120, GetParam());
        const double scale = 60.0 / std::tan(30.0 * pi / 180.0), outline = scale / std::sqrt(distance * distance - 1.0);
        for (std::size_t p = 0; p < image.index.size(); ++p) {
            const double r = std::hypot(static_cast<double>(p % 120) - 59.5, static_cast<double>(p / 120) - 59.5);
            if (r < outline - 1.0) {
                ASSERT_GE(image.index[p], 0) << distance << " " << p;
            }
        }
    }
}

// A cube of points: disks end at its edges, and its outline is straight but for the corners, where three planes meet.
TEST_P(SplatFilter, DisksEndAtSharpEdges) {
    Surfels s;
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {1.0, -1.0}) {
            for (int i = 0; i < 400; ++i) {
                Vec3 p, normal;
                p[axis] = normal[axis] = side;
                p[(axis + 1) % 3] = 0.1 * (i % 20) - 0.95;
                p[(axis + 2) % 3] = 0.1 * (i / 20) - 0.95;
                add_disk(s, p, normal, 0.08);
            }
        }
    }
    const Picture image = picture(s, constant(s, {1, 1, 1}), {}, front, 400, 400, GetParam());
    const double edge = 200.0 / std::tan(30.0 * pi / 180.0) / 3.0;  // of the near face
    std::size_t outside = 0, holes = 0;
    for (std::size_t p = 0; p < image.index.size(); ++p) {
        const double x = std::abs(static_cast<double>(p % 400) - 199.5),
                     y = std::abs(static_cast<double>(p / 400) - 199.5);
        outside += image.index[p] >= 0 && std::max(x, y) > edge + 1.0;
        holes += image.index[p] < 0 && std::max(x, y) < edge - 1.0;
    }
    EXPECT_EQ(holes, 0u);
    EXPECT_LE(outside, 4u * 40u);  // where disks overhang the edges there are 2000
}

// Layers go through the same weights, four at a time, whatever their number.
TEST_P(SplatFilter, LayersAreBlendedAlike) {
    const Surfels ball = sphere(300, {0, 0, 0}, 1.0);
    std::vector<SplatLayer> layers;
    for (int k = 0; k < 6; ++k) {
        SplatLayer layer;
        for (const Vec3& p : ball.positions) layer.values.push_back({1.0 + k, 2.0 + p.x, 0.5 * k});
        layer.emitters_lit = k < 3;
        layers.push_back(layer);
    }
    const VisibleEmitter lamp{{-0.2, -1.5, -0.2}, {0.4, 0, 0}, {0, 0, 0.4}, {7, 7, 7}};
    const SplatImage image = splat_image(ball, layers, {lamp}, front, 60, 50, {}, {}, GetParam());
    ASSERT_EQ(image.layers.size(), 6u);
    for (std::size_t p = 0; p < image.index.size(); ++p) {
        for (std::size_t k = 0; k < 6; ++k) {
            const float* value = &image.layers[k][3 * p];
            if (image.index[p] == -1) {
                ASSERT_EQ(value[2], 0.0f);
            } else if (image.index[p] < -1) {
                ASSERT_EQ(value[0], k < 3 ? 7.0f : 0.0f);
            } else {
                ASSERT_NEAR(value[0], 1.0 + static_cast<double>(k), 1e-5);
                ASSERT_EQ(value[1], image.layers[0][3 * p + 1]);
            }
        }
    }
}

// Rows by themselves are those of the whole.
TEST_P(SplatFilter, BandsAreRowsOfTheWhole) {
    Surfels s = sphere(400, {0, 0, 0.3}, 1.0);
    add_square(s, {-2, 1.5, -2}, {4, 0, 0}, {0, 0, 4}, 6);
    std::vector<Rgb> radiance;
    for (const Vec3& p : s.positions) radiance.push_back({2.0 + p.x, 2.0 + p.y, 2.0 + p.z});
    SplatOptions options;
    options.samples = 2;
    const Picture whole = picture(s, radiance, {}, front, 90, 71, GetParam(), options);
    for (const auto& [first, count] : {std::array{0, 30}, std::array{30, 23}, std::array{53, 40}}) {
        options.rows = {static_cast<std::size_t>(first), static_cast<std::size_t>(count)};
        const Picture band = picture(s, radiance, {}, front, 90, 71, GetParam(), options);
        ASSERT_EQ(band.height, static_cast<std::size_t>(std::min(count, 71 - first)));
        std::size_t different = 0;
        for (std::size_t k = 0; k < band.radiance.size(); ++k) {
            const std::size_t there = 3 * 90 * static_cast<std::size_t>(first) + k;
            different += std::abs(band.radiance[k] - whole.radiance[there]) > 1e-4f;
        }
        // A row's slope is rounded by itself: no more than single subpixels on outlines may differ.
        EXPECT_LE(different, 12u);
    }
}

TEST(SplatProgress, IsAskedBetweenBandsAndMayCancel) {
    const Surfels ball = sphere(100, {0, 0, 0}, 1.0);
    const std::vector<SplatLayer> layers{{constant(ball, {1, 1, 1})}};
    SplatOptions options;
    options.samples = 4;
    std::vector<std::array<std::size_t, 2>> asked;
    splat_image(ball, layers, {}, front, 400, 300, options, [&](std::size_t done, std::size_t total) {
        asked.push_back({done, total});
        return true;
    });
    ASSERT_GE(asked.size(), 3u);
    EXPECT_EQ(asked.front(), (std::array<std::size_t, 2>{0, 300}));
    EXPECT_EQ(asked.back(), (std::array<std::size_t, 2>{300, 300}));
    EXPECT_TRUE(std::is_sorted(asked.begin(), asked.end()));
    EXPECT_THROW(splat_image(ball, layers, {}, front, 400, 300, options,
                             [&](std::size_t done, std::size_t) { return done == 0; }),
                 Cancelled);
}

// On a torus, whose principal curvatures are known: 1 / r around the tube, cos / (R + r cos) along it.
TEST(Bends, AreTheCurvaturesOfATorus) {
    constexpr double big = 2.0, small = 0.7;
    Surfels s;
    std::vector<double> other;
    std::vector<std::uint32_t> all;
    for (int i = 0; i < 180; ++i) {
        for (int j = 0; j < 60; ++j) {
            const double a = 2.0 * pi * (i + 0.5 * (j % 2)) / 180.0, b = 2.0 * pi * j / 60.0;
            const Vec3 normal{std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b)};
            add_disk(s, big * Vec3{std::cos(a), std::sin(a), 0} + small * normal, normal, 0.08);
            other.push_back(-std::cos(b) / (big + small * std::cos(b)));
            all.push_back(static_cast<std::uint32_t>(all.size()));
        }
    }
    const std::vector<Bend> bends = bends_of(s, std::vector<std::int32_t>(s.size(), 0), all, all);
    for (std::size_t k = 0; k < all.size(); ++k) {
        ASSERT_NEAR(std::max(bends[k].along, bends[k].across), std::max(-1.0 / small, other[k]), 0.06);
        ASSERT_NEAR(std::min(bends[k].along, bends[k].across), std::min(-1.0 / small, other[k]), 0.06);
        ASSERT_NEAR(dot(bends[k].direction, s.normals[k]), 0.0, 1e-12);
    }
}

TEST(Bends, NoneWhereNothingIsKnown) {
    Surfels s;
    for (int i = 0; i < 5; ++i) add_disk(s, {0.1 * i, 0, 0}, normalized({0.3 * i, 0, 1}), 0.1);  // a line
    add_disk(s, {9, 9, 9}, {0, 0, 1}, 0.1);
    for (const Bend& bend : bends_of(s, std::vector<std::int32_t>(6, 0), {0, 2, 5}, {0, 1, 2, 3, 4, 5})) {
        EXPECT_EQ(bend.along, 0.0);
        EXPECT_EQ(bend.across, 0.0);
    }
    EXPECT_TRUE(bends_of(s, std::vector<std::int32_t>(6, 0), {}, {0, 1}).empty());
}

// Points all over an ellipsoid are seen within its bounds, and touch them.
TEST(ScreenBounds, AreTightAroundAnEllipsoid) {
    const Frame frame = frame_around(normalized({0.3, -0.5, 0.8}));
    const Ellipsoid e{{0.4, -0.7, 3.0}, {1.2 * frame.u, 0.3 * frame.v, 0.05 * frame.n}};
    for (const int axis : {0, 1}) {
        const auto [low, high] = seen_slopes(e, axis);
        double least = 1e9, most = -1e9;
        for (int i = 0; i <= 400; ++i) {
            for (int j = 0; j < 800; ++j) {
                const double t = pi * i / 400.0, f = 2.0 * pi * j / 800.0;
                const Vec3 p = e.center + std::sin(t) * std::cos(f) * e.axes[0] +
                               std::sin(t) * std::sin(f) * e.axes[1] + std::cos(t) * e.axes[2];
                least = std::min(least, p[axis] / p.z);
                most = std::max(most, p[axis] / p.z);
            }
        }
        EXPECT_NEAR(least, low, 1e-4);
        EXPECT_NEAR(most, high, 1e-4);
        EXPECT_GE(least, low - 1e-12);
        EXPECT_LE(most, high + 1e-12);
    }
    // Around the eye, and behind it: everything.
    const Ellipsoid around{{0, 0, 0.5}, {Vec3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    EXPECT_LT(seen_slopes(around, 0)[0], -1e20);
    const PixelBox all = seen_pixels(around, 1.0, 0.5, 20, 10);
    EXPECT_EQ((std::array{all.left, all.top, all.right, all.bottom}), (std::array{0, 0, 20, 10}));
}

}  // namespace
}  // namespace surflux
