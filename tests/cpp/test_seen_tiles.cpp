#include <vector>

#include <gtest/gtest.h>

#include "surflux/render/seen_tiles.h"

namespace surflux {
namespace {

// 64 x 32 pixels, a pixel of 1 x 1 each: on the left object 0, facing up, on the right object 1, facing left, nothing
// in the lowest row of tiles.
TEST(SeenTiles, KnowWhereAFunctionMaySpeak) {
    std::vector<float> places, normals;
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x) {
            const bool left = x < 32;
            places.insert(places.end(), {static_cast<float>(x), static_cast<float>(y), 0.0f,
                                         y >= 32 ? -1.0f
                                         : left  ? 0.0f
                                                 : 1.0f});
            normals.insert(normals.end(), {left ? 0.0f : -1.0f, 0.0f, left ? 1.0f : 0.0f, 0.0f});
        }
    const SeenTiles tiles(places, normals, 64, 48);
    const SeenTiles::Rectangle whole{0, 0, 64, 48};
    const float up[3] = {0, 0, 1}, left[3] = {-1, 0, 0}, down[3] = {0, 0, -1}, center[3] = {20, 8, 3};
    const auto expect = [&](const SeenTiles::Rectangle& found, int l, int t, int r, int b) {
        EXPECT_EQ((std::vector<int>{found.left, found.top, found.right, found.bottom}), (std::vector<int>{l, t, r, b}));
    };
    expect(tiles.part(whole, center, 4.5f, up, 0.0f), 16, 0, 32, 16);
    expect(tiles.part(whole, center, 9.0f, up, 0.0f), 0, 0, 32, 32);
    expect(tiles.part({18, 3, 40, 10}, center, 9.0f, up, 0.0f), 18, 3, 32, 10);
    expect(tiles.part(whole, center, 13.0f, left, 1.0f), 32, 0, 48, 16);
    EXPECT_TRUE(tiles.part(whole, center, 2.9f, up, 0.0f).empty());    // floats above
    EXPECT_TRUE(tiles.part(whole, center, 9.0f, down, 0.0f).empty());  // faces away
    EXPECT_TRUE(tiles.part(whole, center, 9.0f, up, 1.0f).empty());    // another object
    EXPECT_TRUE(tiles.part(whole, center, 9.0f, up, 2.0f).empty());
    const float below[3] = {20, 46, 0};
    EXPECT_TRUE(tiles.part(whole, below, 9.0f, up, 0.0f).empty());
    EXPECT_TRUE(tiles.part({5, 5, 5, 9}, center, 9.0f, up, 0.0f).empty());
}

}  // namespace
}  // namespace surflux
