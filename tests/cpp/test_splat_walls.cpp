// Pictures of patches: where walls end their kernels, how these reach along long ones, and that no pixel stays open.

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "splat_pictures.h"

namespace surflux {
namespace {

class SplatWalls : public testing::TestWithParam<gl::Api> {};
INSTANTIATE_TEST_SUITE_P(Apis, SplatWalls, testing::Values(gl::Api::egl, gl::Api::osmesa),
                         [](const auto& test) { return test.param == gl::Api::egl ? "egl" : "osmesa"; });

// A floor of two sides, one bright and one dark, on which a wall stands between them, to `end` along it.
Picture beside_a_wall(gl::Api api, double end, const SplatOptions& given = {}) {
    Surfels s;
    add_square(s, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 10);
    SplatOptions options = given;
    options.objects.assign(s.size(), 0);
    std::vector<Rgb> values;
    for (const Vec3& p : s.positions) values.push_back(p.x > 0.0 ? Rgb{1, 1, 1} : Rgb{});
    if (end > -1.0) {
        add_square(s, {0, -1, 0}, {0, 0, 0.4}, {0, end + 1.0, 0}, 4);
        add_square(s, {0, -1, 0}, {0, end + 1.0, 0}, {0, 0, 0.4}, 4);
    }
    options.objects.resize(s.size(), 1);
    values.resize(s.size(), {0.5, 0.5, 0.5});
    const double eye = options.culling ? 4.0 : -4.0;
    return picture(s, values, {}, {{0, 0, eye}, {0, 0, 0}, {0, 1, 0}, 30.0}, 100, 100, api, options);
}

// Of a row of it, pixels where the floor is blended.
std::size_t blended(const Picture& image, std::size_t y) {
    std::size_t count = 0;
    for (std::size_t x = 0; x < image.width; ++x) {
        const double value = pixel(image, x, y).x;
        count += image.index[y * image.width + x] < 100 && value > 1e-6 && value < 1.0 - 1e-6;
    }
    return count;
}

TEST_P(SplatWalls, NothingBleedsBeneathAWall) {
    SplatOptions from_below;
    from_below.culling = false;
    for (const SplatOptions& options : {SplatOptions{}, from_below}) {
        const Picture open = beside_a_wall(GetParam(), -1.0, options), walled = beside_a_wall(GetParam(), 1.0, options);
        for (std::size_t y = 10; y < 91; ++y) {
            ASSERT_GT(blended(open, y), 10u) << y;
            ASSERT_EQ(blended(walled, y), 0u) << y;
        }
    }
}

// A linear field over strips has no steps, however long these are.
TEST_P(SplatWalls, ARampOverLongPatchesIsSmooth) {
    for (const int strips : {1, 10, 100}) {
        Surfels s;
        std::vector<Rgb> values;
        for (int k = 0; k < strips; ++k) {
            add_square(s, {-1, -1.0 + 2.0 * k / strips, 0}, {2, 0, 0}, {0, 2.0 / strips, 0}, 1);
            const double y = (k + 0.5) / strips;
            values.push_back({y, y, y});
        }
        const Picture image = picture(s, values, {}, {{0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 30.0}, 200, 200, GetParam());
        double steepest = 0.0;
        for (std::size_t y = 21; y < 180; ++y)
            for (std::size_t x = 21; x < 180; ++x)
                steepest = std::max({steepest, std::abs(pixel(image, x, y).x - pixel(image, x - 1, y).x),
                                     std::abs(pixel(image, x, y).x - pixel(image, x, y - 1).x)});
        EXPECT_LT(steepest, 0.01) << strips;  // it is .0054 a pixel
    }
}

// Around its end light gets as if there was none: from 1.5 patches on all is as in the open.
TEST_P(SplatWalls, LightBlendsRoundTheEndOfAWall) {
    const Picture open = beside_a_wall(GetParam(), -1.0), walled = beside_a_wall(GetParam(), 0.0);
    ASSERT_EQ(blended(walled, 80), 0u);  // y is -0.6
    for (std::size_t x = 0; x < 100; ++x) ASSERT_NEAR(pixel(walled, x, 20).x, pixel(open, x, 20).x, 1e-6) << x;
}

// Two halves of a sheet, cut into other numbers of patches: corners of the one lie within edges of the other.
TEST_P(SplatWalls, NothingIsSeenBetweenPatchesThatAreCut) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> number(-0.3, 0.3);
    for (int k = 0; k < 20; ++k) {
        const Vec3 along{0.1 + number(random), 2.0, number(random)}, corner{number(random), -1, number(random)};
        Surfels s;
        add_square(s, corner - Vec3{4, 0, 0}, {4, 0, 0}, along, 7);
        add_square(s, corner, {4, 0, 0}, along, 11);
        const Picture image =
            picture(s, constant(s, {1, 1, 1}), {}, {{0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 20.0}, 400, 400, GetParam());
        EXPECT_EQ(std::count(image.index.begin(), image.index.end(), -1), 0) << k;
    }
}

}  // namespace
}  // namespace surflux
