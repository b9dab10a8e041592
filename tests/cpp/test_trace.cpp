#include <gtest/gtest.h>

#include "shapes.h"
#include "surflux/trace/tracer.h"

namespace surflux {
namespace {

using shapes::disk;
using shapes::scene_of;

const Vec3 up{0, 0, 1}, down{0, 0, -1};

TEST(Tracer, ADiskBlocksInsideItsRadiusFromBothSides) {
    for (const Vec3& offset : {Vec3{}, Vec3{5e6, 5e6, 5e6}})
        for (const Vec3& normal : {up, down}) {
            const Vec3 floor = offset, lamp = offset + Vec3{0, 0, 2};
            const Scene scene = scene_of({disk(floor, up, 0.1), disk(offset + Vec3{0, 0, 1}, normal, 0.25)});
            const Tracer tracer(scene);
            EXPECT_FALSE(tracer.free(segment(tracer.on(0, floor), lamp)));
            EXPECT_FALSE(tracer.free(
                segment(tracer.on(0, floor), lamp + Vec3{0.48, 0, 0})));  // crosses the disk's plane at 0.24
            EXPECT_TRUE(tracer.free(segment(tracer.on(0, floor), lamp + Vec3{0.52, 0, 0})));  // at 0.26
            EXPECT_FALSE(tracer.free({tracer.on(0, floor), up}));
            EXPECT_TRUE(tracer.free(segment(tracer.on(0, floor), floor + Vec3{0, 0, 0.9})));  // ends before the disk
            const Hit hit = tracer.closest({tracer.on(0, floor), up});
            EXPECT_EQ(hit.surfel, 1u);
            EXPECT_EQ(hit.front, normal == down);
        }
}

TEST(Tracer, SegmentsBetweenSurfelsIgnoreTheirOwnDisks) {
    const Scene scene = scene_of({disk({0, 0, 0}, up, 0.5), disk({0, 0, 1}, down, 0.5)});
    const Tracer tracer(scene);
    EXPECT_TRUE(tracer.free(segment(tracer.on(0, {0, 0, 0}), {0, 0, 1}, 1)));
    EXPECT_TRUE(tracer.free(segment(tracer.on(0, {0.4, 0, 0}), {-0.4, 0, 1}, 1)));
}

TEST(Tracer, NoPairInsideOrOutsideASphereIsFalselyBlocked) {
    for (double sign : {-1.0, 1.0}) {
        const Scene scene = scene_of({shapes::sphere(400, 1.0, sign, 0.5, 0.0)});
        const Tracer tracer(scene);
        const Surfels& s = scene.surfels;
        for (std::uint32_t i = 0; i < s.size(); ++i) {
            for (std::uint32_t j = 0; sign < 0.0 && j < s.size(); ++j)
                ASSERT_TRUE(i == j || tracer.free(segment(tracer.on(i, s.positions[i]), s.positions[j], j)))
                    << i << " " << j;
            // Cosine-distributed rays: from outside all escape, from inside none does, down to grazing ones.
            EvenPoints even(2, 0, i);
            const Frame frame = frame_around(s.normals[i]);
            for (int k = 0; k < 64; ++k) {
                const double* u = even.next();
                const Vec3 d = frame.to_world(square_to_cosine_hemisphere(u[0], u[1]));
                ASSERT_EQ(bool(tracer.closest({tracer.on(i, s.positions[i]), d})), sign < 0.0);
                ASSERT_EQ(tracer.free({tracer.on(i, s.positions[i]), d}), sign > 0.0);
            }
        }
    }
}

TEST(Tracer, NoRaySeesTheBackOfAClosedConvexCloud) {
    // Lines from all around, isotropic: those that graze it pass under the rims of disks, which stand off the sphere.
    for (const std::size_t n : {100u, 300u, 1000u}) {
        const Scene scene = scene_of({shapes::sphere(n, 1.0, 1.0, 0.5, 0.0)});
        const Tracer tracer(scene);
        std::vector<Ray> rays;
        std::vector<Hit> hits;
        std::vector<bool> meets;
        EvenPoints even(4, 1, n);
        for (int k = 0; k < 20000; ++k) {
            const double* u = even.next();
            const double z = 1.0 - 2.0 * u[0], ring = std::sqrt(1.0 - z * z), turn = 2.0 * pi * u[1];
            const Frame frame = frame_around({ring * std::cos(turn), ring * std::sin(turn), z});
            const double distance = 1.1 * std::sqrt(u[2]), angle = 2.0 * pi * u[3];
            const Vec3 beside = distance * (std::cos(angle) * frame.u + std::sin(angle) * frame.v);
            rays.push_back({{beside - 4.0 * frame.n, frame.n, Hit::none}, frame.n});
            meets.push_back(distance < 1.0);
        }
        tracer.closest(rays, hits);
        for (std::size_t k = 0; k < rays.size(); ++k) {
            ASSERT_TRUE(hits[k] || !meets[k]) << n << " " << k;
            ASSERT_TRUE(hits[k].front || !hits[k]) << n << " " << k;
        }
    }
}

TEST(Tracer, OpenCloudsBlockFromBehind) {
    // Half a sphere, seen from its middle, and a layer over another of the same object, nearer than their disks reach.
    Surfels dome;
    const Surfels whole = shapes::sphere(2000, 1.0, 1.0, 0.5, 0.0);
    for (std::uint32_t i = 0; i < whole.size(); ++i)
        if (whole.positions[i].z > 0.0)
            dome.positions.push_back(whole.positions[i]), dome.normals.push_back(whole.normals[i]);
    shapes::finish(dome, 0.5, 0.0);
    dome.radii = estimate_radii(dome.positions);
    dome.areas.assign(dome.size(), 1.0);
    const Scene half = scene_of({dome});
    const Tracer of_half(half);
    EvenPoints even(2, 1, 0);
    const auto upwards = [&even] {
        const double* u = even.next();
        Vec3 d = square_to_cosine_hemisphere(u[0], u[1]);
        d.z = std::max(d.z, 0.2);
        return normalized(d);
    };
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    for (int k = 0; k < 2000; ++k) rays.push_back({{{}, up, Hit::none}, upwards()});
    of_half.closest(rays, hits);
    for (const Hit& hit : hits) ASSERT_TRUE(hit && !hit.front);

    Surfels layers;
    for (int layer = 0; layer < 2; ++layer)
        for (int x = 0; x < 40; ++x)
            for (int y = 0; y < 40; ++y) {
                layers.positions.push_back({0.1 * x, 0.1 * y, 0.03 * layer});
                layers.normals.push_back(normalized(Vec3{0.1 * std::sin(x), 0.1 * std::cos(y), 1.0}));
            }
    shapes::finish(layers, 0.5, 0.0);
    layers.radii.assign(layers.size(), 0.12);
    layers.areas.assign(layers.size(), 0.01);
    const Scene both = scene_of({layers});
    const Tracer of_layers(both);
    rays.clear();
    for (const double height : {-1.0, 0.015})
        for (int k = 0; k < 2000; ++k) rays.push_back({{{2.0, 2.0, height}, up, Hit::none}, upwards()});
    of_layers.closest(rays, hits);
    for (std::size_t k = 0; k < rays.size(); ++k) {
        if (rays[k].direction.z < 0.6) continue;
        ASSERT_TRUE(hits[k] && !hits[k].front) << k;
        ASSERT_EQ(hits[k].surfel < 1600, rays[k].from.position.z < 0.0) << k;
    }
}

TEST(Tracer, WhatTouchesButFacesTheSurfelBlocks) {
    // A lid of the same object 1e-3 of a radius above: near, overlapping, and an obstacle all the same.
    Surfels floor = disk({0, 0, 0}, up, 0.5);
    const Surfels lid = disk({0, 0, 5e-4}, down, 0.5);
    Scene scene = scene_of({floor, lid});
    scene.object = {0, 0};
    const Tracer tracer(scene);
    EXPECT_FALSE(tracer.free({tracer.on(0, {0, 0, 0}), up}));
    EXPECT_EQ(tracer.closest({tracer.on(0, {0, 0, 0}), up}).surfel, 1u);
}

TEST(Tracer, TwoSidedSheetsAreSeenFromEitherSideAndDoNotBlockThemselves) {
    Surfels grid;
    for (int x = 0; x < 5; ++x)
        for (int y = 0; y < 5; ++y) {
            grid.positions.push_back({0.1 * x, 0.1 * y, 0.01 * std::sin(1.5 * x)});  // slightly wavy
            grid.normals.push_back(up);
        }
    shapes::finish(grid, 0.5, 0.0);
    grid.radii.assign(25, 0.15);
    grid.areas.assign(25, 0.01);
    const Scene scene = scene_of({two_sided(grid), disk({0.2, 0.2, 1}, down, 0.3), disk({0.2, 0.2, -1}, up, 0.3)});
    const Tracer tracer(scene);
    const std::uint32_t front = 12, back = 37, above = 50, below = 51;
    const Vec3 middle = grid.positions[12];
    EXPECT_EQ(tracer.closest({tracer.on(front, middle), up}).surfel, above);
    EXPECT_EQ(tracer.closest({tracer.on(back, middle), down}).surfel, below);
    EXPECT_FALSE(tracer.free(segment(tracer.on(above, {0.2, 0.2, 1}), {0.2, 0.2, -1}, below)));
    const Hit from_above = tracer.closest({tracer.on(above, {0.2, 0.2, 1}), down}),
              from_below = tracer.closest({tracer.on(below, {0.2, 0.2, -1}), up});
    EXPECT_TRUE(from_above.front);
    EXPECT_LT(from_above.surfel, 25u);
    EXPECT_TRUE(from_below.front);
    EXPECT_GE(from_below.surfel, 25u);
}

TEST(Tracer, MeshSurfelsBlockByTheirTrianglesNotTheirDisks) {
    Surfels square;
    shapes::add_rectangle(square, {-0.5, -0.5, 1}, {0, 1, 0}, {1, 0, 0}, 1, 1);  // faces down
    shapes::finish(square, 0.5, 0.0);
    const Scene scene = scene_of({disk({0, 0, 0}, up, 0.1), square});
    const Tracer tracer(scene);
    const Vec3 o;
    EXPECT_FALSE(tracer.free({tracer.on(0, o), {0.49, 0, 1}}));
    EXPECT_TRUE(tracer.free({tracer.on(0, o), {0.51, 0, 1}}));  // inside the circumscribed disk, outside the square
    EXPECT_TRUE(tracer.closest({tracer.on(0, o), {0.2, 0.2, 1}}).front);
}

TEST(Tracer, ABentPatchDoesNotBlockItselfFarFromWhereRaysLeave) {
    Surfels trough;
    trough.positions = {{0, 0, 0.4}};
    trough.normals = {up};
    trough.radii = {1.5};
    trough.areas = {2.5};
    trough.triangles = {{{-1, -1, 1}, {0, -1, 0}, {0, 1, 0}, 0}, {{0, -1, 0}, {1, 1, 1}, {0, 1, 0}, 0}};
    shapes::finish(trough, 0.5, 0.0);
    const Tracer tracer(scene_of({trough}));
    const Vec3 from{-1.0 / 3.0, -1.0 / 3.0, 1.0 / 3.0}, across{1.0 / 3.0, 0.1, 1.0 / 3.0};
    const Vec3 beyond = from + 3.0 * (across - from);
    const auto arrives = [&](const Departure& place) { return tracer.free(segment(place, beyond)); };
    EXPECT_TRUE(arrives(tracer.on(0, from)));
    EXPECT_FALSE(tracer.closest({tracer.on(0, from), normalized(across - from)}));
    EXPECT_FALSE(arrives({from + Vec3{0, 0, 0.1}, up}));  // a place in the air: the same patch blocks
}

TEST(Tracer, NoRaySlipsOutOfAClosedBox) {
    const Scene scene = scene_of({shapes::cube_inside(8, 0.5, 0.0)});
    const Tracer tracer(scene);
    Random random(1);
    for (int k = 0; k < 20000; ++k) {
        const Vec3 d = normalized({random.uniform() - 0.5, random.uniform() - 0.5, random.uniform()});
        ASSERT_TRUE(tracer.closest({tracer.on(0, scene.surfels.positions[0]), d}).front);
    }
}

// Sixteen at once, of which the last may be fewer, find what each finds by itself.
TEST(Tracer, CoherentRaysFindWhatSingleOnesDo) {
    Surfels patches;
    shapes::add_rectangle(patches, {-2, -2, -1.5}, {4, 0, 0}, {0, 4, 0}, 5, 5);
    shapes::add_rectangle(patches, {0.5, 1.2, -1}, {0, 0, 2}, {-2, 0, 0}, 3, 3);
    shapes::finish(patches, 0.5, 0.0);
    const Scene scene = scene_of({shapes::sphere(500, 1.0, 1.0, 0.5, 0.0), patches});
    const Tracer tracer(scene);
    const Surfels& s = scene.surfels;
    for (const std::size_t count : {0u, 1u, 16u, 35u, 1000u}) {
        std::vector<Ray> rays;
        for (std::size_t k = 0; k < count; ++k) {
            Random random(4, k);
            const auto i = static_cast<std::uint32_t>(random.below(s.size()));
            const Departure from = tracer.on(i, s.positions[i]);
            const Frame frame = frame_around(s.normals[i]);
            const Vec3 d = frame.to_world(square_to_cosine_hemisphere(random.uniform(), random.uniform()));
            const auto j = static_cast<std::uint32_t>(random.below(s.size()));
            if (k % 3 == 0) rays.push_back({from, d});
            if (k % 3 == 1) rays.push_back(segment(from, from.position + 2.0 * d));
            if (k % 3 == 2) rays.push_back(segment(from, s.positions[j], j));
        }
        std::vector<Hit> hits, together;
        std::vector<char> free, free_together;
        tracer.closest(rays, hits);
        tracer.closest_coherent(rays, together);
        tracer.free(rays, free);
        tracer.free_coherent(rays, free_together);
        EXPECT_EQ(free, free_together);
        ASSERT_EQ(together.size(), count);
        std::size_t met = 0;
        for (std::size_t k = 0; k < count; ++k) {
            if (k % 3 == 2) continue;  // ends on what it meets, up to rounding
            EXPECT_EQ(hits[k].surfel, together[k].surfel) << k;
            EXPECT_EQ(hits[k].front, together[k].front) << k;
            EXPECT_NEAR(hits[k].distance, together[k].distance, 1e-6) << k;
            met += hits[k].surfel != Hit::none;
        }
        if (count == 1000) {
            EXPECT_GT(met, 100u);
            EXPECT_LT(met, 600u);
        }
    }
}

}  // namespace
}  // namespace surflux
