#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "refusal.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/environment.h"
#include "surflux/lights/sky_patches.h"

namespace surflux {
namespace {

TEST(SkyPatches, AreAsManyAsTregenzaAndReinhartHave) {
    for (const auto& [subdivision, count] : {std::pair(1, 145u), std::pair(2, 577u), std::pair(4, 2305u)}) {
        const SkyPatches patches(subdivision);
        EXPECT_EQ(patches.size(), count + 1u);
        const std::vector<double>& angles = patches.solid_angles();
        EXPECT_NEAR(std::accumulate(angles.begin() + 1, angles.end(), 0.0), 2.0 * pi, 1e-12);
        EXPECT_DOUBLE_EQ(angles[0], 2.0 * pi);
    }
    // Tregenza's rows are 12 degrees high, his cap reaches 6 degrees from the zenith.
    const SkyPatches tregenza(1);
    EXPECT_NEAR(tregenza.directions()[1].z, std::sin(6.0 * pi / 180.0), 1e-15);
    EXPECT_NEAR(tregenza.directions()[1].y, std::cos(6.0 * pi / 180.0), 1e-15);
    EXPECT_NEAR(tregenza.solid_angles()[145], 2.0 * pi * (1.0 - std::cos(6.0 * pi / 180.0)), 1e-15);
    // The second one of 30 is 12 degrees east of north.
    EXPECT_NEAR(std::atan2(tregenza.directions()[2].x, tregenza.directions()[2].y), 12.0 * pi / 180.0, 1e-15);
}

TEST(SkyPatches, FindTheirMiddlesAndAllThatIsInThem) {
    Random random(1, 0);
    for (const int subdivision : {1, 2, 4, 8}) {
        const SkyPatches patches(subdivision);
        for (std::size_t k = 0; k < patches.size(); ++k) {
            ASSERT_EQ(patches.index_of(3.0 * patches.directions()[k]), k);
            for (int i = 0; i < 10; ++i) {
                const double u = 1e-9 + (1.0 - 2e-9) * random.uniform(), v = 1e-9 + (1.0 - 2e-9) * random.uniform();
                ASSERT_EQ(patches.index_of(patches.place_in(k, u, v)), k) << u << " " << v;
            }
        }
    }
}

TEST(SkyPatches, HaveTheirPlacesInProportionToSolidAngle) {
    // Irradiance of the patch on a level plane, in closed form: pi (sin^2 high - sin^2 low) / count of a row, by the
    // midpoint rule in sin(altitude), which is exact for it.
    const SkyPatches patches(2);
    double all = 0.0;
    for (std::size_t k = 1; k < patches.size(); ++k) {
        double sum = 0.0;
        for (int i = 0; i < 16; ++i) sum += patches.place_in(k, 0.3, (i + 0.5) / 16).z / 16;
        all += sum * patches.solid_angles()[k];
    }
    EXPECT_NEAR(all, pi, 1e-12);
}

TEST(SkyPatches, TheHorizonIsSkyAndWhatIsBelowIsGround) {
    const SkyPatches patches(1);
    EXPECT_EQ(patches.index_of({0, 1, 0}), 1u);
    EXPECT_EQ(patches.index_of({0, 1, -1e-9}), 0u);
    EXPECT_EQ(patches.index_of({1, 0, 0}), 9u);  // east: 7.5 patches on from the first, 1
    EXPECT_EQ(patches.index_of({0, 0, 5}), 145u);
}

Environment image_of(std::size_t width, std::size_t height, const Rgb& value) {
    Environment sky;
    sky.width = width, sky.height = height;
    sky.pixels.assign(width * height, value);
    sky.up = normalized({0.1, 0.3, 0.9});
    sky.azimuth = 33.0;
    return sky;
}

TEST(SkyPatches, HaveTheMeansOfASky) {
    // Even skies stay even; in a patch that one pixel fills radiance is the pixel's.
    const SkyPatches patches(2);
    for (const Rgb& radiance : patch_radiances(image_of(7, 5, {1, 2, 3}), patches))
        EXPECT_LT(length(radiance - Rgb{1, 2, 3}), 1e-12);
    Environment constant;
    constant.radiance = {1, 2, 3};
    for (const Rgb& radiance : patch_radiances(constant, patches)) EXPECT_EQ(radiance, constant.radiance);

    Environment sky = image_of(9, 6, {});
    Random random(2, 0);
    for (Rgb& pixel : sky.pixels) pixel = {random.uniform(), 0.0, 1.0};
    const std::vector<Rgb> found = patch_radiances(sky, patches);
    const EnvironmentMap map(sky);
    std::size_t inside = 0;
    for (std::size_t k = 1; k + 1 < patches.size(); ++k) {
        bool one = true;
        const Rgb middle = map.radiance(patches.directions()[k]);
        for (int i = 0; i < 81; ++i) one = one && map.radiance(patches.place_in(k, i / 9 / 8.0, i % 9 / 8.0)) == middle;
        if (!one) continue;
        ++inside;
        EXPECT_NEAR(found[k].x, middle.x, 1e-12);
    }
    EXPECT_GT(inside, 200u);
}

TEST(SkyPatches, KeepThePowerOfASun) {
    // One pixel of 1.4 degrees among 145 patches: of the pieces of a patch, 16 along each side, the 64 on its border
    // are in or out: a standard deviation of sqrt(64 / 12) pieces if they were independent, .9 % of 256; four of them.
    const SkyPatches patches(1);
    for (const std::size_t at : {20 * 256 + 7, 40 * 256 + 100, 50 * 256 + 200}) {
        Environment sky = image_of(256, 128, {});
        sky.pixels[at] = {1e5, 0, 0};
        const double row = static_cast<double>(at / 256);
        const double power = 1e5 * (std::cos(pi * row / 128) - std::cos(pi * (row + 1) / 128)) * 2.0 * pi / 256;
        const std::vector<Rgb> found = patch_radiances(sky, patches);
        double sum = 0.0;
        for (std::size_t k = 0; k < patches.size(); ++k) sum += found[k].x * patches.solid_angles()[k];
        EXPECT_NEAR(sum, power, 0.036 * power);
    }
}

TEST(SkyPatches, RefuseWhatIsNoSubdivision) {
    EXPECT_EQ(refusal([] { SkyPatches(0); }), "subdivision: wanted 1 to 8 rows of each of Tregenza's, got 0");
    EXPECT_EQ(refusal([] { SkyPatches(9); }), "subdivision: wanted 1 to 8 rows of each of Tregenza's, got 9");
}

}  // namespace
}  // namespace surflux
