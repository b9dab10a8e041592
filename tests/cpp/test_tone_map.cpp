#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "surflux/core/error.h"
#include "surflux/render/tone_map.h"

namespace surflux {
namespace {

TEST(ToneMap, AutomaticExposureBringsTheLogAverageToItsTarget) {
    std::vector<float> rgb;
    for (int i = 0; i < 1000; ++i) {  // luminances 2^-5 ... 2^5, evenly in the logarithm: their log-average is 1
        const float v = std::exp2(static_cast<float>(i - 499.5) / 100.0f);
        rgb.insert(rgb.end(), {v, v, v});
    }
    EXPECT_NEAR(automatic_exposure(rgb), 0.22, 1e-4);
    // A black background, a grey one, lamps, and pixels that are not numbers change nothing.
    const std::vector<float> alone = rgb;
    for (const float v : {0.0f, 0.01f, 1e6f, std::nanf(""), std::numeric_limits<float>::infinity()}) {
        std::vector<float> more = alone;
        more.insert(more.end(), 1500, v);
        EXPECT_NEAR(automatic_exposure(more), 0.22, 1e-4) << v;
    }
}

TEST(ToneMap, FlatAndBlackPicturesHaveAnExposure) {
    EXPECT_NEAR(automatic_exposure(std::vector<float>(300, 4.0f)), 0.22 / 4.0, 1e-6);
    EXPECT_EQ(automatic_exposure(std::vector<float>(300, 0.0f)), 1.0);
    EXPECT_EQ(automatic_exposure({}), 1.0);
}

TEST(ToneMap, IsMonotonicAndBounded) {
    std::vector<float> rgb;
    for (int i = 0; i < 300; ++i) rgb.push_back(0.01f * static_cast<float>(i));
    const std::vector<float> display = tone_map(rgb, {1.0, true});
    for (std::size_t i = 1; i < rgb.size(); ++i) {
        ASSERT_GT(display[i], display[i - 1]);
        ASSERT_LE(display[i], std::min(1.0f, rgb[i]));
        if (rgb[i] <= 0.6f) {
            ASSERT_EQ(display[i], rgb[i]);
        }
    }
    EXPECT_EQ(tone_map({0.5f, 1.5f, 3.0f}, {0.5, false}), (std::vector<float>{0.25f, 0.75f, 1.0f}));
}

TEST(ToneMap, OnePoisonedPixelStaysAlone) {
    const float inf = std::numeric_limits<float>::infinity();
    const std::vector<float> display = tone_map({std::nanf(""), inf, -inf, 0.3f, 0.3f, 0.3f}, {1.0, true});
    EXPECT_EQ(display, (std::vector<float>{0.0f, 1.0f, 0.0f, 0.3f, 0.3f, 0.3f}));
    EXPECT_THROW(tone_map({1.0f, 1.0f, 1.0f}, {0.0, true}), ArgumentError);
    EXPECT_THROW(tone_map({1.0f, 1.0f}, {}), ArgumentError);
}

}  // namespace
}  // namespace surflux
