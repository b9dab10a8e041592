#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "refusal.h"
#include "shapes.h"
#include "surflux/neighbors/piles.h"
#include "surflux/scene/extent.h"
#include "surflux/trace/coincident.h"
#include "surflux/trace/tracer.h"

namespace surflux {
namespace {

using shapes::scene_of;

// `count` equal disks at one place.
Surfels pile_of(std::size_t count, const Vec3& place, const Vec3& normal) {
    return select(shapes::disk(place, normal, 0.5), std::vector<std::uint32_t>(count, 0));
}

TEST(Coincident, TwinsOfAPileAreMatchedOneByOne) {
    // As many of either side as two_sided makes of a pile; what was compared pair by pair here took as long as k^2.
    constexpr std::uint32_t k = 20000;
    const Scene scene = scene_of({two_sided(pile_of(k, {1, 2, 3}, normalized({0.3, -0.5, 0.8})))});
    const Coincident found = find_coincident(scene);
    for (std::uint32_t i = 0; i < k; ++i) {
        ASSERT_EQ(found.twin[i], k + i);
        ASSERT_EQ(found.twin[k + i], i);
        ASSERT_EQ(found.is_copy[i], i > 0);
    }
}

TEST(Coincident, TwinsAreOfOneSizeAndOppositeAndOfOneObjectIfTheyCan) {
    Surfels s = select(shapes::disk({}, {0, 0, 1}, 0.5), {0, 0, 0, 0, 0});
    s.normals[1] = normalized({0.0012, 0, -1});  // .07 degrees off, within rounding of floats and more
    s.normals[2] = normalized({0.01, 0, -1});
    s.normals[3] = {0, 0, -1};
    s.radii[3] = 0.4;
    const Coincident found = find_coincident(scene_of({s, pile_of(1, {}, {0, 0, -1})}));
    EXPECT_EQ(found.twin, (std::vector<std::uint32_t>{1, 0, Hit::none, Hit::none, 5, 4}));
    EXPECT_EQ(found.is_copy, (std::vector<char>{0, 0, 0, 0, 1, 0}));
}

TEST(Coincident, TwinsMayBeOfTwoObjects) {
    const Surfels up = pile_of(1, {}, {0, 0, 1}), down = pile_of(1, {}, {0, 0, -1});
    EXPECT_EQ(find_coincident(scene_of({up, down})).twin, (std::vector<std::uint32_t>{1, 0}));
    // A sheet of two objects on which one of two sides lies: its own sides stay together.
    EXPECT_EQ(find_coincident(scene_of({up, two_sided(up)})).twin, (std::vector<std::uint32_t>{Hit::none, 2, 1}));
}

TEST(Coincident, RaysMeetAPileOnce) {
    const Scene scene = scene_of({pile_of(1000, {}, {0, 0, 1}), shapes::disk({0, 0, 1}, {0, 0, -1}, 0.5)});
    const Tracer tracer(scene);
    for (const std::uint32_t i : {0u, 1u, 999u}) {
        EXPECT_TRUE(tracer.free(segment(tracer.on(i, {}), {0, 0, 1}, 1000)));
        EXPECT_EQ(tracer.closest({tracer.on(i, {}), {0, 0, 1}}).surfel, 1000u);
        EXPECT_TRUE(tracer.free({tracer.on(i, {}), {1, 0, 0.1}}));
    }
    EXPECT_EQ(tracer.closest({tracer.on(1000, {0, 0, 1}), {0, 0, -1}}).surfel, 0u);
}

TEST(Piles, HoldWhatCoincidesAndFacesAlike) {
    Surfels s = select(shapes::disk({}, {0, 0, 1}, 0.5), {0, 0, 0, 0, 0, 0});
    s.normals[1] = {0, 0, -1};
    s.normals[3] = {0, 1, 0};
    s.radii = {3, 1, 1, 1, 2, 1};
    s.positions[5] = {1e-9, 0, 0};
    const auto piles = find_piles(s.positions, s.normals, s.radii, 0.999);
    ASSERT_EQ(piles.size(), 1u);
    EXPECT_EQ(piles[0].front(), 4u);  // of median radius
    EXPECT_EQ(std::set<std::uint32_t>(piles[0].begin(), piles[0].end()), (std::set<std::uint32_t>{0, 2, 4}));
}

TEST(Extent, StraysAndPilesLeaveItAsItIs) {
    const Surfels cube = shapes::cube_inside(4, 0.5, 0.0);
    const Extent alone{cube};
    EXPECT_NEAR(length(alone.middle - Vec3{0.5, 0.5, 0.5}), 0.0, 0.5);
    EXPECT_GT(alone.size, 1.0);
    EXPECT_LE(alone.size, std::sqrt(3.0) + 0.5);
    for (const double far : {1e3, 1e9}) {
        const Extent extent(scene_of({cube, pile_of(500, {far, 0, 0}, {0, 0, 1})}).surfels);
        // One place more: medians move by a place, at most a patch of 1/4, and what is measured from them by as much.
        EXPECT_LE(length(extent.middle - alone.middle), std::sqrt(3.0) / 4);
        EXPECT_NEAR(extent.size, alone.size, 2.0 * std::sqrt(3.0) / 4);
        // What is near touches no sooner, what is far by what floats leave of its place.
        EXPECT_LE(extent.contact_of(0), 2.0 * alone.contact_of(0));
        EXPECT_GE(extent.contact_of(96), far * 0x1p-24);
    }
}

TEST(Extent, RefusesWhatFloatsCannotHold) {
    for (const double size : {1e-35, 1e35}) {
        const Surfels s = shapes::disk({}, {0, 0, 1}, size);
        EXPECT_EQ(refusal([&] { Extent{s}; }).find("scene: it is "), 0u);
    }
    const Scene far = scene_of({shapes::cube_inside(4, 0.5, 0.0), pile_of(1, {1e12, 0, 0}, {0, 0, 1})});
    EXPECT_EQ(refusal([&] { Tracer{far}; }).find("scene: surfel 96 reaches "), 0u);
}

TEST(Tracer, SeesTheSameInAnyUnitOfLength) {
    Surfels s = shapes::cube_inside(4, 0.5, 0.0);
    const Vec3 direction = normalized({0.3, 0.5, 0.8});
    const Hit expected = Tracer(scene_of({s})).closest({{s.positions[0], s.normals[0], 0}, direction});
    ASSERT_TRUE(bool(expected));
    for (const int exponent : {-90, -66, 44, 90}) {
        const double scale = std::ldexp(1.0, exponent);
        Surfels t = s;
        for (Vec3& p : t.positions) p = scale * p;
        for (double& r : t.radii) r *= scale;
        for (Triangle& piece : t.triangles) piece = {scale * piece.a, scale * piece.b, scale * piece.c, piece.surfel};
        const Hit found = Tracer(scene_of({t})).closest({{t.positions[0], t.normals[0], 0}, direction});
        EXPECT_EQ(found.surfel, expected.surfel);
        EXPECT_EQ(found.front, expected.front);
        EXPECT_EQ(found.distance, scale * expected.distance);  // to the last bit
    }
}

}  // namespace
}  // namespace surflux
