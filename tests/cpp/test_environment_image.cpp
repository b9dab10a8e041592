#include "surflux/render/environment_image.h"

#include <gtest/gtest.h>

#include "refusal.h"

#include "surflux/core/parallel.h"

namespace surflux {
namespace {

const Camera aslant{{5, 6, 7}, {6, 8, 6}, {0.2, -0.1, 1}, 70.0};

// Two rows and four columns, of other colours each, turned some way.
Environment turned() {
    Environment sky;
    sky.width = 4;
    sky.height = 2;
    for (int k = 0; k < 8; ++k) sky.pixels.push_back({1.0 + k, 0.5 * k, 8.0 - k});
    sky.up = {0.6, 0.0, 0.8};
    sky.azimuth = 30.0;
    return sky;
}

TEST(EnvironmentImage, SkiesAddUpAndOtherLightsAreNotSeen) {
    const std::vector<float> open(12 * 9, 0.0f);
    const std::vector<float> image = environment_image({turned()}, aslant, 12, 9, 2, open);
    Environment plain;
    plain.radiance = {0.25, 0.5, 4};
    const std::vector<float> both =
        environment_image({plain, PointLight{{6, 8, 6}, {1, 1, 1}}, turned()}, aslant, 12, 9, 2, open);
    for (std::size_t k = 0; k < image.size(); ++k)
        ASSERT_FLOAT_EQ(both[k], image[k] + (k % 3 == 0 ? 0.25f : k % 3 == 1 ? 0.5f : 4.0f));
}

// Of subpixels it is the mean of a picture that is as much finer; where something covers a share, the rest of that.
TEST(EnvironmentImage, IsAMeanTimesWhatIsLeft) {
    std::vector<float> coverage(12 * 9);
    for (std::size_t k = 0; k < coverage.size(); ++k) coverage[k] = static_cast<float>(k % 5) / 4.0f;
    const std::vector<float> found = environment_image({turned()}, aslant, 12, 9, 3, coverage);
    const std::vector<float> fine = environment_image({turned()}, aslant, 36, 27, 1, std::vector<float>(36 * 27));
    for (std::size_t k = 0; k < found.size(); ++k) {
        const std::size_t pixel = k / 3, x = pixel % 12, y = pixel / 12;
        float sum = 0.0f;
        for (std::size_t s = 0; s < 9; ++s) sum += fine[3 * ((3 * y + s / 3) * 36 + 3 * x + s % 3) + k % 3];
        ASSERT_NEAR(found[k], (1.0f - coverage[pixel]) * sum / 9.0f, 1e-5f);
    }
}

TEST(EnvironmentImage, IsTheSameForAnyNumberOfThreads) {
    const std::vector<float> open(80 * 60), all = environment_image({turned()}, aslant, 80, 60, 2, open);
    for (const int threads : {1, 3}) {
        const ThreadLimit limit(threads);
        ASSERT_EQ(environment_image({turned()}, aslant, 80, 60, 2, open), all);
    }
}

TEST(EnvironmentImage, RefusesByName) {
    EXPECT_EQ(refusal([] { environment_image({}, aslant, 4, 3, 1, std::vector<float>(11)); }),
              "coverage: wanted one number for each of 12 pixels, got 11");
    EXPECT_EQ(refusal([] { environment_image({}, aslant, 4, 3, 0, std::vector<float>(12)); }),
              "samples: wanted 1 to 16, got 0");
}

}  // namespace
}  // namespace surflux
