#include "surflux/render/mip_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "refusal.h"

namespace surflux {
namespace {

std::vector<float> noise(std::size_t count) {
    std::vector<float> out;
    for (std::size_t k = 0; k < count; ++k)
        out.push_back(static_cast<float>((k * 7919 + k * k * 104729) % 1009) / 1008);
    return out;
}

double mean_of(const MipMap& texture, const TexturePlace& at, const TexturePlace& side, const TexturePlace& other) {
    double out = 0.0;
    texture.mean(at, side, other, &out);
    return out;
}

TEST(MipMap, HasTheMeanOfAllTexelsWhereAllAreSeen) {
    for (const auto& [width, height] :
         {std::pair<std::size_t, std::size_t>{16, 16}, {7, 5}, {37, 64}, {9, 1}, {1, 30}}) {
        const std::vector<float> texels = noise(width * height);
        double mean = 0.0;
        for (const float value : texels) mean += static_cast<double>(value) / static_cast<double>(texels.size());
        const MipMap texture(texels, width, height, 1);
        EXPECT_NEAR(mean_of(texture, {0.3, 0.8}, {2.0, 0.0}, {0.0, 2.0}), mean,
                    std::min(width, height) > 1 ? 2e-5 : 0.01)
            << width << " x " << height;
    }
}

TEST(MipMap, HasATexelInItsMiddleAndLinearMeansBetweenAcrossTheBorder) {
    const std::vector<float> texels = noise(8 * 4);
    const MipMap texture(texels, 8, 4, 1);
    const auto near = [&](double x, double y) { return mean_of(texture, {x / 8, y / 4}, {1e-6, 0.0}, {0.0, 1e-6}); };
    EXPECT_NEAR(near(2.5, 1.5), static_cast<double>(texels[8 + 2]), 2e-5);
    EXPECT_NEAR(near(2.75, 1.5), 0.75 * static_cast<double>(texels[10]) + 0.25 * static_cast<double>(texels[11]), 2e-5);
    EXPECT_NEAR(near(8.0, 0.5), 0.5 * static_cast<double>(texels[7] + texels[0]), 2e-5);  // it repeats itself
    EXPECT_NEAR(near(-5.5, -2.5), near(2.5, 1.5), 1e-9);
}

TEST(MipMap, DoesNotBlurAcrossWhatIsSeenAtASlant) {
    std::vector<float> stripes;
    for (std::size_t k = 0; k < 64 * 64; ++k) stripes.push_back(k % 64 < 32 ? 1.0f : 0.0f);
    const MipMap texture(stripes, 64, 64, 1);
    // Twelve texels along the stripes and one across: all white, and the other way the mean.
    EXPECT_NEAR(mean_of(texture, {16.5 / 64, 0.5}, {0.0, 12.0 / 64}, {1.0 / 64, 0.0}), 1.0, 1e-4);
    EXPECT_NEAR(mean_of(texture, {0.5, 0.5}, {12.0 / 64, 0.0}, {0.0, 1.0 / 64}), 0.5, 0.05);
    // Of sides that are no right angle what counts is the strip that they make.
    EXPECT_NEAR(mean_of(texture, {16.5 / 64, 0.5}, {0.0, 12.0 / 64}, {1.0 / 64, 11.0 / 64}), 1.0, 1e-4);
}

TEST(MipMap, KeepsDarkValuesAndChannelsApart) {
    const MipMap texture({0.0003f, 0.5f, 0.0003f, 0.5f}, 2, 1, 2);
    double out[2];
    texture.mean({0.2, 0.5}, {0.1, 0.0}, {0.0, 0.1}, out);
    EXPECT_NEAR(out[0], 0.0003, 3e-7);
    EXPECT_NEAR(out[1], 0.5, 2e-5);
}

TEST(MipMap, RefusesTexelsOfAnotherNumber) {
    EXPECT_EQ(refusal([] { MipMap({1.0f, 1.0f}, 2, 2, 1); }), "texels: wanted some, 1 values each, got 2 of 2 x 2");
    EXPECT_EQ(refusal([] { MipMap({}, 0, 2, 1); }), "texels: wanted some, 1 values each, got 0 of 0 x 2");
}

}  // namespace
}  // namespace surflux
