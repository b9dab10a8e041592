#include <gtest/gtest.h>

#include <algorithm>

#include "shapes.h"
#include "surflux/core/parallel.h"
#include "surflux/trace/facing.h"

namespace surflux {
namespace {

struct Cloud {
    std::vector<Vec3> points, normals;
    void add(const Surfels& s, double sign, const Vec3& shift = {}) {
        for (std::size_t i = 0; i < s.size(); ++i) {
            points.push_back(s.positions[i] + shift);
            normals.push_back(sign * s.normals[i]);
        }
    }
};

std::size_t turned(const Facing& found) {
    return static_cast<std::size_t>(std::count(found.turned.begin(), found.turned.end(), 1));
}

TEST(Facing, OfABodyTurnsItAsAWhole) {
    for (const double sign : {1.0, -1.0}) {
        Cloud ball;
        ball.add(shapes::sphere(2000, 1.0, 1.0, 0.5, 0.0), sign);
        const Facing found = facing_of(ball.points, ball.normals, {});
        ASSERT_EQ(found.sheets.size(), 1u);
        EXPECT_EQ(found.sheets[0].kind, SheetKind::body);
        EXPECT_EQ(found.sheets[0].backwards, sign < 0.0);
        EXPECT_EQ(found.sheets[0].against, 0.0);
        EXPECT_EQ(found.sheets[0].tangled, 0.0);
        // Nothing leaves from inside, and nothing else is there to be met outside.
        EXPECT_NEAR(found.sheets[0].margin, sign, 0.02);
        EXPECT_EQ(turned(found), sign < 0.0 ? 2000u : 0u);
    }
}

TEST(Facing, OfABallInABallMakesARoomOfTheOuterOne) {
    Cloud cloud;
    cloud.add(shapes::sphere(3000, 1.0, 1.0, 0.5, 0.0), 1.0);  // seen from inside: turned
    cloud.add(shapes::sphere(1000, 0.4, 1.0, 0.5, 0.0), 1.0);
    const Facing found = facing_of(cloud.points, cloud.normals, {});
    ASSERT_EQ(found.sheets.size(), 2u);
    EXPECT_EQ(found.sheets[found.sheet.front()].kind, SheetKind::room);
    EXPECT_EQ(found.sheets[found.sheet.back()].kind, SheetKind::body);
    for (std::size_t i = 0; i < cloud.points.size(); ++i) EXPECT_EQ(found.turned[i], i < 3000 ? 1 : 0);
}

// A ball rests on a floor, and all normals point upwards, as estimated ones do that face the sky.
TEST(Facing, OfABallOnAFloorHasTwoSheets) {
    Cloud cloud;
    cloud.add(shapes::sphere(3000, 0.6, 1.0, 0.5, 0.0), 1.0, {0.0, 0.0, 0.6});
    const std::size_t ball = cloud.points.size();
    for (int i = 0; i < 100; ++i)
        for (int k = 0; k < 100; ++k) {
            cloud.points.push_back({0.04 * i - 2.0, 0.04 * k - 2.0, 0.0});
            cloud.normals.push_back({0, 0, 1});
        }
    std::vector<bool> under(ball);
    for (std::size_t i = 0; i < ball; ++i) {
        under[i] = cloud.normals[i].z < 0.0;
        if (under[i]) cloud.normals[i] = -cloud.normals[i];
    }
    FacingOptions options;
    options.sheets.estimated = true;
    const Facing found = facing_of(cloud.points, cloud.normals, options);
    ASSERT_EQ(found.sheets.size(), 2u);
    EXPECT_EQ(found.sheets[found.sheet.front()].kind, SheetKind::body);
    EXPECT_EQ(found.sheets[found.sheet.back()].kind, SheetKind::open);
    EXPECT_EQ(found.sheets[found.sheet.back()].bodies, 1.0);  // they are seen from above alone
    // Where the gap is no wider than points are apart, either sheet may have them.
    for (std::size_t i = 0; i < ball; ++i)
        if (cloud.points[i].z > 0.05) {
            EXPECT_EQ(found.turned[i], under[i]);
        }
}

TEST(Facing, OfWhatClosesAroundAWitnessIsARoom) {
    Cloud ball;
    ball.add(shapes::sphere(2000, 1.0, 1.0, 0.5, 0.0), -1.0);
    for (const double x : {0.5, 3.0}) {
        FacingOptions options;
        options.sheets.witnesses = {{x, 0, 0}};
        const Facing found = facing_of(ball.points, ball.normals, options);
        EXPECT_EQ(found.sheets[0].kind, x < 1.0 ? SheetKind::room : SheetKind::body);
        EXPECT_EQ(turned(found), x < 1.0 ? 0u : 2000u);
    }
}

TEST(Facing, OfACapIsOpen) {
    Cloud cap;
    const Surfels s = shapes::sphere(4000, 1.0, 1.0, 0.5, 0.0);
    for (std::size_t i = 0; i < s.size(); ++i)
        if (s.positions[i].z > 0.8) cap.points.push_back(s.positions[i]), cap.normals.push_back(-s.normals[i]);
    const Facing found = facing_of(cap.points, cap.normals, {});
    EXPECT_EQ(found.sheets[0].kind, SheetKind::open);
    EXPECT_EQ(turned(found), 0u);
    // The mean normal of a cap from z = .8 on has length .9; of its 400 points the 67 on the rim, where it is .8, may
    // have neighbours at one side alone, and twice the area.
    EXPECT_LT(found.sheets[0].flat, 0.9);
    EXPECT_GT(found.sheets[0].flat, (400 * 0.9 + 67 * 0.8) / 467 - 1e-3);
}

TEST(Facing, IsTheSameForAnyNumberOfThreadsAndPointsFollowThoseLookedAt) {
    Cloud ball;
    ball.add(shapes::sphere(5000, 1.0, 1.0, 0.5, 0.0), -1.0);
    FacingOptions options;
    options.most = 1000;
    const Facing all = facing_of(ball.points, ball.normals, options);
    EXPECT_EQ(turned(all), 5000u);
    EXPECT_EQ(all.sheets[0].size, 5000u);
    const ThreadLimit one(1);
    const Facing again = facing_of(ball.points, ball.normals, options);
    EXPECT_EQ(again.turned, all.turned);
    EXPECT_EQ(again.sheets[0].margin, all.sheets[0].margin);
}

// Where few places are looked at, most backs follow points elsewhere, and stay all the same.
TEST(Facing, LeavesBothSidesOfASheetHoweverManyAreLookedAt) {
    for (const std::size_t most : {500u, 1000u, 5000u}) {
        for (const std::uint64_t seed : {0u, 1u, 2u}) {
            Cloud ball;
            const Surfels s = shapes::sphere(5000, 1.0, 1.0, 0.5, 0.0);
            ball.add(s, 1.0);
            ball.add(s, -1.0);
            ball.add(s, 1.0);  // a third one at each place
            FacingOptions options;
            options.most = most;
            options.sheets.seed = seed;
            const Facing found = facing_of(ball.points, ball.normals, options);
            EXPECT_EQ(turned(found), 0u);
            EXPECT_FALSE(found.sheets.empty());
        }
    }
}

// Of a ball that faces inwards one point in ten has a back at the same place: both stay, and the others are turned.
TEST(Facing, TurnsWhatHasNoBackAmongPairs) {
    const Surfels s = shapes::sphere(5000, 1.0, 1.0, 0.5, 0.0);
    Cloud ball;
    ball.add(s, -1.0);
    for (std::size_t i = 0; i < s.size(); i += 10)
        ball.points.push_back(s.positions[i]), ball.normals.push_back(s.normals[i]);
    for (const std::size_t most : {1000u, 5000u}) {
        for (const std::uint64_t seed : {0u, 1u, 2u}) {
            FacingOptions options;
            options.most = most;
            options.sheets.seed = seed;
            const Facing found = facing_of(ball.points, ball.normals, options);
            for (std::size_t i = 0; i < ball.points.size(); ++i)
                EXPECT_EQ(found.turned[i], i < s.size() && i % 10 != 0 ? 1 : 0);
        }
    }
}

TEST(Facing, OfPointsAtFewPlacesIsNone) {
    Cloud pile;
    pile.points.assign(100, {1, 2, 3});
    pile.normals.assign(100, {0, 0, 1});
    const Facing found = facing_of(pile.points, pile.normals, {});
    EXPECT_EQ(turned(found), 0u);
    EXPECT_TRUE(found.sheets.empty());
}

TEST(Facing, StopsWhenTold) {
    Cloud ball;
    ball.add(shapes::sphere(500, 1.0, 1.0, 0.5, 0.0), 1.0);
    EXPECT_THROW(facing_of(ball.points, ball.normals, {}, [](std::size_t, std::size_t) { return false; }), Cancelled);
}

}  // namespace
}  // namespace surflux
