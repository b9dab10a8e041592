#include "surflux/render/flat_image.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "refusal.h"
#include "splat_pictures.h"

namespace surflux {
namespace {

// A ball of disks before three squares of patches, half of each another object, a wall that stands on one of them, and
// a lamp that hides some of all.
struct Things {
    Surfels surfels = sphere(400, {0.2, -1.6, 0.3}, 0.5);
    std::vector<VisibleEmitter> lamps{{{-0.9, -1.9, -0.2}, {0.5, 0, 0}, {0, 0, 0.4}, {7, 8, 9}}};
    std::vector<std::int32_t> objects;
    std::vector<Rgb> values;

    Things() {
        for (int k = 0; k < 3; ++k) add_square(surfels, {-1.5, 0.3 * k, -1.0 + k}, {3, 0, 0}, {0, 1, 1}, 6);
        add_square(surfels, {-0.7, 0, -1}, {0, 0.8, 0.8}, {0, -0.3, 0.3}, 3);
        std::mt19937 random(3);
        std::uniform_real_distribution<double> number(0.0, 1.0);
        for (std::size_t k = 0; k < surfels.size(); ++k) {
            objects.push_back(surfels.positions[k].x > 0.2 ? 1 : 0);
            values.push_back({number(random), 10.0 * number(random), number(random)});
        }
    }
};

// It draws what splat_image draws: two implementations of the same weights, one in shaders.
void expect_the_same(const Camera& camera, const SplatOptions& given, std::size_t width, std::size_t height) {
    const Things things;
    SplatOptions options = given;
    options.objects = things.objects;
    const SplatImage drawn =
        splat_image(things.surfels, {{things.values}}, things.lamps, camera, width, height, options);
    const FlatImage flat = flat_image(things.surfels, things.lamps, camera, width, height, options);
    const std::vector<float> found = flat.draw(things.values, {things.lamps[0].radiance});
    ASSERT_EQ(flat.coverage(), drawn.coverage);
    ASSERT_EQ(found.size(), 3 * width * height);
    std::size_t surfels = 0, lamps = 0, nothing = 0;
    for (std::size_t p = 0; p < drawn.index.size(); ++p) {
        (drawn.index[p] >= 0 ? surfels : drawn.index[p] == -1 ? nothing : lamps) += 1;
        for (std::size_t c = 0; c < 3; ++c) {
            const float wanted = drawn.layers[0][3 * p + c];
            ASSERT_NEAR(found[3 * p + c], wanted, 2e-5f * std::max(1.0f, wanted)) << p;
        }
    }
    for (const std::size_t count : {surfels, lamps, nothing}) EXPECT_GT(count, 50u);
}

TEST(FlatImage, IsTheSplattedOne) { expect_the_same(front, {}, 120, 90); }

TEST(FlatImage, IsTheSplattedOneOfSubpixels) {
    SplatOptions options;
    options.samples = 3;
    options.culling = false;
    expect_the_same({{-2, -4, 2}, {0, 0, 0}, {0, 0, 1}, 50.0}, options, 90, 70);
}

TEST(FlatImage, IsTheSplattedOneOfParallelRays) {
    expect_the_same({{0, -4, 0.5}, {0, 0, 0.3}, {0, 0, 1}, 45.0, 4.5}, {}, 100, 80);
}

// 2^20 subpixels are drawn at once: here are three bands of them, and blocks that end with none.
TEST(FlatImage, IsTheSplattedOneInBands) {
    SplatOptions options;
    options.samples = 8;
    expect_the_same(front, options, 250, 161);
}

// Pixels that see surfels alone show a mean of them, and pictures add up as light does.
TEST(FlatImage, IsLinearAndConstantsStayConstant) {
    const Things things;
    const FlatImage flat = flat_image(things.surfels, things.lamps, front, 80, 60);
    const std::vector<float> even = flat.draw(constant(things.surfels, {2, 2, 2}), {{2, 2, 2}});
    for (std::size_t k = 0; k < even.size(); ++k) ASSERT_NEAR(even[k], 2.0f * flat.coverage()[k / 3], 1e-5f);
    std::vector<Rgb> twice = things.values;
    for (Rgb& value : twice) value *= 2.0;
    const std::vector<float> once = flat.draw(things.values, {Rgb{}}), both = flat.draw(twice, {Rgb{}});
    for (std::size_t k = 0; k < once.size(); ++k) ASSERT_EQ(both[k], 2.0f * once[k]);
    EXPECT_GT(flat.entries(), 80u * 60u);
    EXPECT_EQ(flat.bytes(), 8u * (80u * 60u + 1u) + 8u * flat.entries() + 4u * 80u * 60u);
}

TEST(FlatImage, ArgumentsAreRefusedByName) {
    const Things things;
    const FlatImage flat = flat_image(things.surfels, things.lamps, front, 8, 6);
    const auto drawn = [&](const std::vector<Rgb>& values, const std::vector<Rgb>& lamps) {
        return refusal([&] { flat.draw(values, lamps); });
    };
    EXPECT_EQ(drawn({{1, 1, 1}}, {Rgb{}}), "values: wanted one RGB value for each of 517 surfels, got 1");
    EXPECT_EQ(drawn(things.values, {}), "emitters: wanted the radiance of each of 1, got 0");
    EXPECT_EQ(drawn(things.values, {{0, std::nan(""), 0}}), "values: wanted finite numbers");
    EXPECT_EQ(refusal([&] { flat_image(things.surfels, {}, front, 0, 6); }),
              "size: wanted 1 to 65536 pixels a side, got 0 x 6");
}

}  // namespace
}  // namespace surflux
