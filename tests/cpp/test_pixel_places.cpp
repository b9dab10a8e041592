#include "surflux/render/pixel_places.h"

#include <cmath>

#include <gtest/gtest.h>

#include "refusal.h"
#include "shapes.h"
#include "surflux/render/smooth_cells.h"

namespace surflux {
namespace {

// A tilted square before a wall, and a quad of two triangles that make a patch.
std::vector<Surfels> things() {
    Surfels wall, tilted;
    shapes::add_rectangle(wall, {-3, 2, -3}, {6, 0, 0}, {0, 0, 6}, 5, 5);
    shapes::add_rectangle(tilted, {-1, 0, -1}, {1.5, 0.3, 0}, {0.1, 0.4, 1.5}, 4, 4);
    for (Surfels* s : {&wall, &tilted}) shapes::finish(*s, 0.5, 0.0);
    return {wall, tilted};
}

constexpr std::size_t width = 90, height = 70;
const Camera camera{{0.3, -4, 0.5}, {0, 0, 0}, {0, 0, 1}, 60.0};

TEST(PixelPlaces, LieOnTheRayAndInThePlaneOfTheirPatch) {
    const CompiledScene compiled(shapes::scene_of(things()));
    const Surfels& surfels = compiled.scene().surfels;
    for (const double tall : {0.0, 5.0}) {
        Camera look = camera;
        look.height = tall;
        const PixelPlaces places = pixel_places(compiled, look, width, height);
        std::size_t of[2] = {0, 0};
        for (std::size_t p = 0; p < places.size(); ++p) {
            if (!places.is_seen(p)) {
                EXPECT_TRUE(std::isinf(places.depth[p]));
                continue;
            }
            ++of[places.surfel[p] < 25 ? 0 : 1];
            const double x = static_cast<double>(p % width), y = static_cast<double>(p / width);
            const Vec3 place = places.place(p), way = place - places.rays.origin(x, y);
            // Floats from an eye up to 7 away.
            EXPECT_NEAR(length(cross(way, normalized(places.rays.direction(x, y)))), 0.0, 1e-6);
            const Triangle& triangle = surfels.triangles[places.triangle[p]];
            ASSERT_EQ(triangle.surfel, places.surfel[p]);
            EXPECT_NEAR(dot(place - triangle.a, normalized(cross_of(triangle))), 0.0, 1e-6);
            const Vec3 weights = corner_weights(triangle, place);
            for (int k = 0; k < 3; ++k) EXPECT_GT(weights[k], -1e-5);
            EXPECT_NEAR(length(weights.x * triangle.a + weights.y * triangle.b + weights.z * triangle.c - place), 0.0,
                        1e-6);
            EXPECT_NEAR(places.depth[p], dot(place - look.eye, normalized(look.target - look.eye)), 1e-6);
        }
        EXPECT_GT(of[0], 1000u);
        EXPECT_GT(of[1], 300u);
    }
}

// With a disk out of sight, the same scene is drawn by OpenGL: two ways to find the same.
TEST(PixelPlaces, AreTheSameByRaysAndByDrawing) {
    std::vector<Surfels> with_disk = things();
    with_disk.push_back(shapes::disk({0, -9, 0}, {0, 1, 0}, 0.1));
    const CompiledScene rays(shapes::scene_of(things())), drawn(shapes::scene_of(with_disk));
    for (const bool culling : {true, false}) {
        // From behind the wall, which is seen through or not.
        for (const Camera& look : {camera, Camera{{0.5, 6, 1}, {0, 0, 0}, {0, 0, 1}, 50.0}}) {
            const PixelPlaces one = pixel_places(rays, look, width, height, culling),
                              other = pixel_places(drawn, look, width, height, culling);
            std::size_t differ = 0, seen = 0;
            for (std::size_t p = 0; p < one.size(); ++p) {
                seen += one.is_seen(p);
                if (one.surfel[p] != other.surfel[p]) {
                    ++differ;
                    continue;
                }
                if (one.is_seen(p)) {
                    EXPECT_NEAR(one.depth[p], other.depth[p], 1e-5);
                }
            }
            EXPECT_LT(differ, 40u);  // at edges, where the two round otherwise
            EXPECT_EQ(seen > 3000, !culling || look.eye.y < 0);
        }
    }
}

TEST(PixelPlaces, DisksHaveTheNormalOfTheirSurface) {
    const CompiledScene compiled(shapes::scene_of({shapes::sphere(1500, 1.0, 1.0, 0.5, 0.0)}));
    const PixelPlaces places = pixel_places(compiled, camera, 4 * width, 4 * height);  // small disks are drawn flat
    std::size_t seen = 0;
    for (std::size_t p = 0; p < places.size(); ++p) {
        if (!places.is_seen(p)) continue;
        ++seen;
        EXPECT_EQ(places.triangle[p], PixelPlaces::none);
        const Vec3 place = places.place(p);
        if (dot(normalized(place), normalized(camera.eye - place)) < 0.3) continue;  // the outline
        EXPECT_NEAR(length(place), 1.0, 5e-3);
        EXPECT_GT(dot(places.normal_at(p), normalized(place)), 0.999);
    }
    EXPECT_GT(seen, 10000u);
}

TEST(PixelPlaces, RefuseNoPixels) {
    const CompiledScene compiled(shapes::scene_of(things()));
    EXPECT_EQ(refusal([&] { pixel_places(compiled, camera, 0, 10); }),
              "size: wanted 1 to 65536 pixels a side, got 0 x 10");
}

// Cells are parts of squares on one surface; where surfaces meet, each pixel is one.
TEST(SmoothCells, PartTheSquaresAtBorders) {
    const CompiledScene compiled(shapes::scene_of(things()));
    const PixelPlaces places = pixel_places(compiled, camera, width, height);
    for (const std::size_t side : {1u, 4u, 5u}) {
        const SmoothCells cells(places, side);
        std::vector<std::size_t> sizes(cells.probes().size(), 0);
        std::size_t alone = 0;
        for (std::size_t p = 0; p < places.size(); ++p) {
            ASSERT_EQ(places.is_seen(p), cells.cell(p) != SmoothCells::none);
            if (!places.is_seen(p)) continue;
            const std::size_t probe = cells.probes()[cells.cell(p)];
            ++sizes[cells.cell(p)];
            ASSERT_EQ(cells.cell(probe), cells.cell(p));
            ASSERT_EQ(probe % width / side, p % width / side);
            ASSERT_EQ(probe / width / side, p / width / side);
            ASSERT_EQ(places.surfel[probe] < 25, places.surfel[p] < 25);
            bool border = false;
            const auto beside = [&](bool inside, std::size_t q) {
                border = border || (inside && places.is_seen(q) && (places.surfel[q] < 25) != (places.surfel[p] < 25));
            };
            beside(p % width > 0, p - 1);
            beside(p % width + 1 < width, p + 1);
            beside(p >= width, p - width);
            beside(p + width < places.size(), p + width);
            if (border) {
                ++alone;
                ASSERT_EQ(probe, p);
            }
        }
        EXPECT_GT(alone, 50u);
        // A square of the wall is a cell.
        EXPECT_EQ(*std::max_element(sizes.begin(), sizes.end()), side * side);
    }
}

// In a column of squares, probes stand in all columns of pixels, and so do those of a row of squares.
TEST(SmoothCells, ProbesStandInAllRowsAndColumns) {
    Surfels wall;
    shapes::add_rectangle(wall, {-9, 2, -9}, {18, 0, 0}, {0, 0, 18}, 5, 5);
    shapes::finish(wall, 0.5, 0.0);
    const CompiledScene compiled(shapes::scene_of({wall}));
    const PixelPlaces places = pixel_places(compiled, camera, 64, 64);
    const SmoothCells cells(places, 4);
    ASSERT_EQ(cells.probes().size(), 256u);
    for (std::size_t column = 0; column < 16; ++column) {
        std::size_t across[4] = {}, down[4] = {};
        for (const std::uint32_t p : cells.probes()) {
            if (p % 64 / 4 == column) ++across[p % 4];
            if (p / 64 / 4 == column) ++down[p / 64 % 4];
        }
        for (std::size_t k = 0; k < 4; ++k) {
            EXPECT_EQ(across[k], 4u);
            EXPECT_EQ(down[k], 4u);
        }
    }
}

}  // namespace
}  // namespace surflux
