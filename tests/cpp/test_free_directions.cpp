#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "refusal.h"
#include "shapes.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/free_directions.h"
#include "surflux/lights/patch_rays.h"

namespace surflux {
namespace {

std::vector<Vec3> random_directions(std::size_t count) {
    Random random(5, 0);
    std::vector<Vec3> out;
    while (out.size() < count) {
        const Vec3 d{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
        if (length(d) > 0.1) out.push_back(normalized(d));
    }
    return out;
}

std::vector<std::uint32_t> all_of(const Scene& scene) {
    std::vector<std::uint32_t> out(scene.surfels.size());
    std::iota(out.begin(), out.end(), 0u);
    return out;
}

bool bit(const FreeDirections& found, std::size_t row, std::size_t j) {
    const std::size_t bytes = FreeDirections::row_bytes(found.directions);
    return (found.bits[row * bytes + j / 8] >> (7 - j % 8) & 1) != 0;
}

// A ball over others, of disks; `wall`: beside one of triangles.
Scene balls(bool wall) {
    Scene scene;
    append(scene, shapes::sphere(300, 1.0, 1.0, 0.5, 0.0));
    append(scene, shapes::sphere(200, 0.5, 1.0, 0.5, 0.0, {0.0, 0.4, 2.0}));
    if (wall) {
        Surfels patches;
        shapes::add_rectangle(patches, {1.5, -2.0, -2.0}, {0.0, 0.0, 4.0}, {0.0, 4.0, 0.0}, 5, 5);
        shapes::finish(patches, 0.5, 0.0);
        append(scene, patches);
    }
    return scene;
}

TEST(FreeDirections, AreWhatShadowRaysFindOneByOne) {
    const std::vector<Vec3> directions = random_directions(61);
    for (const bool wall : {false, true}) {
        const Scene scene = balls(wall);
        const Surfels& s = scene.surfels;
        const Tracer tracer(scene);
        const FreeDirections found = find_free_directions(s, all_of(scene), tracer, directions);
        std::size_t free = 0, hidden = 0;
        for (std::uint32_t i = 0; i < s.size(); ++i)
            for (std::size_t j = 0; j < directions.size(); ++j) {
                const bool faces = dot(s.normals[i], directions[j]) > 0.0;
                const bool expected = faces && tracer.free({tracer.on(i, s.positions[i]), directions[j]});
                ASSERT_EQ(bit(found, i, j), expected) << i << ", " << j;
                free += expected, hidden += faces && !expected;
            }
        EXPECT_GT(free, 1000u);
        EXPECT_GT(hidden, 300u);
        const std::vector<std::uint32_t> some{17, 3, 400};
        const FreeDirections of_some = find_free_directions(s, some, tracer, directions);
        for (std::size_t k = 0; k < some.size(); ++k)
            for (std::size_t j = 0; j < directions.size(); ++j) EXPECT_EQ(bit(of_some, k, j), bit(found, some[k], j));
    }
}

TEST(FreeDirections, CanBeCancelled) {
    const Scene scene = balls(false);
    const Tracer tracer(scene);
    EXPECT_THROW(find_free_directions(scene.surfels, all_of(scene), tracer, random_directions(16),
                                      [](std::size_t, std::size_t) { return false; }),
                 Cancelled);
}

// Of three vectors one is behind the plane and one hidden: 2 cos 60 arrives, of that and 3.
TEST(FreeDirections, AreSummedWithAndWithoutTheCosine) {
    const std::vector<Vec3> vectors{{std::sqrt(3.0), 0.0, 1.0}, {0.0, 0.0, 3.0}, {0.0, 0.0, -7.0}};
    const std::uint8_t bits = 0x80;
    const DirectionSums with = sum_directions({{0.0, 0.0, 1.0}}, &bits, vectors, true);
    EXPECT_DOUBLE_EQ(with.arrived[0], 1.0);
    EXPECT_DOUBLE_EQ(with.unoccluded[0], 4.0);
    const DirectionSums without = sum_directions({{0.0, 0.0, 1.0}}, &bits, vectors, false);
    EXPECT_DOUBLE_EQ(without.arrived[0], 2.0);
    EXPECT_DOUBLE_EQ(without.unoccluded[0], 5.0);
}

// Under a radiance of 1 an open plane tilted by b has pi (1 + cos b) / 2 of the sky and pi (1 - cos b) / 2 of the
// ground. Patches are integrated by parts of a side h <= 12 degrees / 4; where the plane's horizon runs through one,
// along its diagonal at most, the midpoint rule misses at most (h sqrt 2)^2 / 8 for each radian, pi in all.
TEST(PatchRays, BringOpenPlanesAllOfTheSkyAndTheGround) {
    const double h = 3.0 * pi / 180.0;
    for (const int subdivision : {1, 2}) {
        const SkyPatches patches(subdivision);
        const PatchRays rays(patches, 2, 7);
        EXPECT_EQ(rays.patches(), patches.size());
        const std::vector<std::uint8_t> open(FreeDirections::row_bytes(rays.directions().size()), 0xff);
        for (const double degrees : {0.0, 0.5, 30.0, 75.0, 90.0, 120.0, 180.0}) {
            const double b = degrees * pi / 180.0;
            const std::vector<double> found = rays.coefficients({{std::sin(b), 0.0, std::cos(b)}}, open.data());
            EXPECT_NEAR(found[0], 0.5 * pi * (1.0 - std::cos(b)), 1e-12);
            const double sky = std::accumulate(found.begin() + 1, found.end(), 0.0);
            EXPECT_NEAR(sky, 0.5 * pi * (1.0 + std::cos(b)), degrees == 0.0 ? 1e-12 : 0.25 * h * h * pi);
        }
        const std::vector<std::uint8_t> hidden(open.size(), 0);
        for (const double c : rays.coefficients({{0.6, 0.0, 0.8}}, hidden.data())) EXPECT_EQ(c, 0.0);
    }
}

TEST(PatchRays, LieInTheirPatches) {
    const SkyPatches patches(2);
    const PatchRays rays(patches, 3, 1);
    std::vector<int> count(patches.size(), 0);
    for (const Vec3& d : rays.directions()) ++count[patches.index_of(d)];
    EXPECT_EQ(count[0], 128);
    for (std::size_t p = 1; p < count.size(); ++p) EXPECT_EQ(count[p], 3) << p;
}

}  // namespace
}  // namespace surflux
