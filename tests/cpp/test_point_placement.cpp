#include <gtest/gtest.h>

#include <algorithm>

#include "refusal.h"
#include "shapes.h"
#include "surflux/core/parallel.h"
#include "surflux/meshless/point_placement.h"

namespace surflux {
namespace {

using shapes::scene_of;

PlacedPoints place(const Scene& scene, int levels, const PlacementOptions& options = {},
                   const SignedDistance& region = {}) {
    const Tracer tracer(scene);
    PointPlacement placement(scene, tracer, options);
    for (int level = 0; level < levels; ++level) placement.add_level(level + 1 == levels ? region : SignedDistance());
    return placement.points();
}

std::size_t level_of(const PlacedPoints& p, std::size_t i) {
    return static_cast<std::size_t>(std::upper_bound(p.level_begin.begin(), p.level_begin.end(), i) -
                                    p.level_begin.begin()) -
           1;
}

// All pairs of an object, exactly.
void expect_apart(const PlacedPoints& p) {
    for (std::size_t i = 0; i < p.size(); ++i) {
        const double radius = p.first_radius[p.objects[i]] * std::pow(0.5, static_cast<double>(level_of(p, i)));
        for (std::size_t j = 0; j < i; ++j) {
            if (p.objects[i] != p.objects[j]) continue;
            const double least = radius * std::max(0.0, dot(p.normals[i], p.normals[j]));
            ASSERT_GE(length(p.positions[i] - p.positions[j]), least * (1.0 - 1e-12)) << i << " " << j;
        }
    }
}

// L07 6.1 to the letter, on patches, in one level: points accepted before 1000 proposals fail in a row.
std::size_t count_by_rejection(const Scene& scene, double radius, std::uint64_t seed) {
    const Surfels& s = scene.surfels;
    std::vector<double> up_to;
    double total = 0.0;
    for (const Triangle& t : s.triangles) up_to.push_back(total += area_of(t));
    Random random(seed, 77);
    std::vector<Vec3> points, normals;
    for (int failed = 0; failed < 1000; ++failed) {
        const auto k = static_cast<std::size_t>(
            std::upper_bound(up_to.begin(), up_to.end() - 1, random.uniform() * total) - up_to.begin());
        const double u = random.uniform();
        const Vec3 w = square_to_triangle(u, random.uniform());
        const Triangle& t = s.triangles[k];
        const Vec3 at = w.x * t.a + w.y * t.b + w.z * t.c, normal = s.normals[t.surfel];
        bool free = true;
        for (std::size_t i = 0; free && i < points.size(); ++i)
            free = length(at - points[i]) >= radius * std::max(0.0, dot(normal, normals[i]));
        if (!free) continue;
        points.push_back(at);
        normals.push_back(normal);
        failed = -1;
    }
    return points.size();
}

Surfels square(int patches, const Vec3& offset = {}) {
    Surfels s;
    shapes::add_rectangle(s, offset, {1, 0, 0}, {0, 1, 0}, patches, patches);
    shapes::finish(s, 0.5, 0.0);
    return s;
}

Surfels box(const Vec3& low, double side) {
    Surfels s = shapes::cube_inside(2, 0.5, 0.0);
    for (Vec3& p : s.positions) p = low + side * p;
    for (Vec3& n : s.normals) n = -n;
    for (double& r : s.radii) r *= side;
    for (double& a : s.areas) a *= side * side;
    for (Triangle& t : s.triangles) {
        std::swap(t.b, t.c);
        for (Vec3* p : {&t.a, &t.b, &t.c}) *p = low + side * *p;
    }
    return s;
}

TEST(PointPlacement, NoTwoPointsAreCloserThanTheirLevelAllows) {
    const Scene scene =
        scene_of({shapes::cube_inside(3, 0.5, 0.0), shapes::sphere(400, 0.3, 1.0, 0.5, 0.0, {0.5, 0.5, 0.5})});
    const PlacedPoints p = place(scene, 3);
    ASSERT_EQ(p.level_begin.size(), 4u);
    EXPECT_EQ(p.level_begin.back(), p.size());
    expect_apart(p);
    for (std::size_t i = 0; i < p.size(); ++i) {
        EXPECT_EQ(p.objects[i], scene.object[p.surfels[i]]);
        EXPECT_EQ(p.normals[i], scene.surfels.normals[p.surfels[i]]);
        const Vec3 off = p.positions[i] - scene.surfels.positions[p.surfels[i]];
        EXPECT_NEAR(dot(off, p.normals[i]), 0.0, 1e-12);
        EXPECT_LE(length(off), scene.surfels.radii[p.surfels[i]] * (1.0 + 1e-12));
    }
}

TEST(PointPlacement, LevelsAreAtLeastAsFullAsAThousandRejectionsMakeThem) {
    // The same shape as few large and as many small patches, and a small object with only some points.
    struct Case {
        Scene scene;
        double radius;
    };
    const std::vector<Case> cases = {{scene_of({square(1)}), 0.05},
                                     {scene_of({square(40)}), 0.05},
                                     {scene_of({square(1)}), 0.4},
                                     {scene_of({shapes::cube_inside(2, 0.5, 0.0)}), 0.12}};
    for (const Case& c : cases) {
        double ours = 0.0, papers = 0.0;
        for (std::uint64_t seed = 0; seed < 8; ++seed) {
            papers += static_cast<double>(count_by_rejection(c.scene, c.radius, seed));
            ours += static_cast<double>(place(c.scene, 1, {c.radius, seed}).size());
        }

        // Eight small squares have some 70 points: their number alone has a spread.
        EXPECT_GE(ours, papers * (papers > 200.0 ? 1.0 : 0.97)) << ours / papers;
    }
}

TEST(PointPlacement, EveryPlaceIsCovered) {
    const Scene scene = scene_of({shapes::cube_inside(3, 0.5, 0.0)});
    const PlacedPoints p = place(scene, 3);
    const double radius = 0.25 * p.first_radius[0];
    Random random(5);
    int open = 0;
    const int tried = 4000;
    for (int k = 0; k < tried; ++k) {
        const Vec3 at{random.uniform(), random.uniform(), 0.0}, up{0, 0, 1};
        bool covered = false;
        for (std::size_t i = 0; !covered && i < p.size(); ++i)
            covered = length(at - p.positions[i]) < radius * std::max(0.0, dot(up, p.normals[i]));
        open += !covered;
    }
    EXPECT_LE(open, tried / 1000);
}

TEST(PointPlacement, PointsAreSpreadEvenlyOverPatchesOfAnySize) {
    // Half of the square in one patch, half in 800.
    Surfels s;
    shapes::add_rectangle(s, {0, 0, 0}, {0.5, 0, 0}, {0, 1, 0}, 1, 1);
    shapes::add_rectangle(s, {0.5, 0, 0}, {0.5, 0, 0}, {0, 1, 0}, 20, 40);
    shapes::finish(s, 0.5, 0.0);
    const PlacedPoints p = place(scene_of({s}), 4);
    const auto large = static_cast<double>(std::count(p.surfels.begin(), p.surfels.end(), 0u));
    EXPECT_NEAR(large / static_cast<double>(p.size()), 0.5, 0.01);
}

TEST(PointPlacement, BothSidesOfASheetHaveTheirOwnPoints) {
    const PlacedPoints p = place(scene_of({two_sided(square(4))}), 2);
    const auto up = std::count_if(p.normals.begin(), p.normals.end(), [](const Vec3& n) { return n.z > 0.0; });
    EXPECT_NEAR(static_cast<double>(up) / static_cast<double>(p.size()), 0.5, 0.04);
    expect_apart(p);
}

TEST(PointPlacement, WhatIsInsideGeometryGetsNoPoints) {
    // A box half sunk in the floor, from (.3, .3) to (.7, .7).
    const Scene scene = scene_of({square(1), box({0.3, 0.3, -0.2}, 0.4)});
    const Scene bare = scene_of({square(1)});
    const double radius = 0.04;
    const PlacedPoints p = place(scene, 2, {radius}), without = place(bare, 2, {radius});
    expect_apart(p);
    const auto count = [](const PlacedPoints& points, double low, double high) {
        int n = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3& x = points.positions[i];
            const double off = std::max(std::abs(x.x - 0.5), std::abs(x.y - 0.5));
            n += points.objects[i] == 0 && off >= low && off < high;
        }
        return n;
    };
    EXPECT_EQ(count(p, 0.0, 0.2), 0);
    EXPECT_GT(count(without, 0.0, 0.2), 100);
    // No hole along the box: as many points beside it as on the bare floor, which has some 200 there.
    EXPECT_GE(count(p, 0.2, 0.25), 0.97 * count(without, 0.2, 0.25));
    EXPECT_NEAR(count(p, 0.25, 0.5), count(without, 0.25, 0.5), 0.03 * count(without, 0.25, 0.5));
}

TEST(PointPlacement, BesideWhatStandsOnAFloorItIsCovered) {
    const double radius = 0.02;
    int open = 0, tried = 0;
    for (const int patches : {1, 7}) {
        const Scene scene = scene_of({square(patches), box({0.3, 0.3, -0.2}, 0.4)});
        const PlacedPoints p = place(scene, 1, {radius});
        Random random(3);
        for (int k = 0; k < 100000; ++k) {
            const Vec3 at{random.uniform(), random.uniform(), 0.0};
            const double off = std::max(std::abs(at.x - 0.5), std::abs(at.y - 0.5));
            if (off < 0.2 || off > 0.2 + radius) continue;
            bool covered = false;
            for (std::size_t i = 0; !covered && i < p.size(); ++i)
                covered = p.objects[i] == 0 && length(at - p.positions[i]) < radius;
            open += !covered;
            ++tried;
        }
    }
    EXPECT_LE(open, tried / 1000);
}

TEST(PointPlacement, OpenScansAndWhatStandsUnderThemLoseNoPoints) {
    // A wavy open cloud, and a table over a floor whose underside nobody saw.
    Surfels wavy;
    for (int x = 0; x < 30; ++x)
        for (int y = 0; y < 30; ++y) {
            const double u = x / 30.0, v = y / 30.0, steep = 0.9 * std::cos(9.0 * u);
            wavy.positions.push_back({u, v, 0.1 * std::sin(9.0 * u)});
            wavy.normals.push_back(normalized({-steep, 0, 1}));
        }
    shapes::finish(wavy, 0.5, 0.0);
    wavy.radii.assign(wavy.size(), 0.04);
    wavy.areas.assign(wavy.size(), 1.0 / 900.0);
    Surfels table = square(6, {2.3, 0.3, 0.3});
    for (Vec3& p : table.positions) p = Vec3{2.3, 0.3, 0.3} + 0.4 * (p - Vec3{2.3, 0.3, 0.3});
    for (Triangle& t : table.triangles)
        for (Vec3* p : {&t.a, &t.b, &t.c}) *p = Vec3{2.3, 0.3, 0.3} + 0.4 * (*p - Vec3{2.3, 0.3, 0.3});
    const Scene scene = scene_of({wavy, square(2, {2, 0, 0}), table}), alone = scene_of({wavy, square(2, {2, 0, 0})});
    const PlacedPoints p = place(scene, 2, {0.05}), without = place(alone, 2, {0.05});
    // Numbers of pieces, and with them the draws, are others beside a table.
    const auto under_table = [](const PlacedPoints& points) {
        int n = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3& x = points.positions[i];
            n += points.objects[i] == 1 && std::abs(x.x - 2.5) < 0.2 && std::abs(x.y - 0.5) < 0.2;
        }
        return n;
    };
    EXPECT_GT(under_table(without), 150);
    EXPECT_GT(under_table(p), 0.95 * under_table(without));
    // Each of its disks, farther apart than the radius, has its point: none was lost to disks of the cloud itself.
    EXPECT_EQ(std::count(p.objects.begin(), p.objects.end(), 0u), 900);
}

TEST(PointPlacement, ALevelIsPlacedInARegion) {
    const Scene scene = scene_of({square(1)});
    const auto from_center = [](const Vec3& p) { return length(p - Vec3{0.5, 0.5, 0}); };
    const SignedDistance disk = [&](const Vec3& p, const Vec3&, std::uint32_t) { return from_center(p) - 0.3; };
    const PlacedPoints some = place(scene, 4, {0.1}, disk), all = place(scene, 4, {0.1});
    expect_apart(some);
    const auto within = [&](const PlacedPoints& p, double radius) {
        std::size_t n = 0;
        for (std::size_t i = p.level_begin[3]; i < p.size(); ++i) n += from_center(p.positions[i]) <= radius;
        return static_cast<double>(n);
    };
    EXPECT_EQ(within(some, 0.3), static_cast<double>(some.size() - some.level_begin[3]));
    // As many as everywhere, but for the rim, where nothing beyond is in the way: there are more.
    EXPECT_NEAR(within(some, 0.27), within(all, 0.27), 0.03 * within(all, 0.27));
    EXPECT_GE(within(some, 0.3) - within(some, 0.27), within(all, 0.3) - within(all, 0.27));
    EXPECT_EQ(some.level_begin[3], all.level_begin[3]);
    const PlacedPoints none = place(scene, 2, {0.1}, [](const Vec3&, const Vec3&, std::uint32_t) { return 1e300; });
    EXPECT_EQ(none.level_begin[1], none.level_begin[2]);
}

TEST(PointPlacement, ARegionOfAnySizeIsFound) {
    // One patch, far longer than the region, which is known a tenth of it ahead.
    const Scene scene = scene_of({square(1)});
    for (const Vec3& center : {Vec3{0.123, 0.456, 0}, Vec3{0.9, 0.05, 0}, Vec3{0.5, 0.5, 0}}) {
        const SignedDistance spot = [&](const Vec3& p, const Vec3&, std::uint32_t) {
            return std::min(0.02, length(p - center) - 0.2);
        };
        EXPECT_GT(place(scene, 1, {0.1}, spot).size(), 2u);
    }
}

TEST(PointPlacement, FirstRadiusFollowsTheObject) {
    const Scene scene = scene_of({square(4), box({3, 0, 0}, 0.02)});
    const PlacedPoints p = place(scene, 1);
    const auto large = std::count(p.objects.begin(), p.objects.end(), 0u);
    const auto small = std::count(p.objects.begin(), p.objects.end(), 1u);
    // About 400 in all, in proportion to areas, but 32 at least; along edges, where nothing beyond is in the way, more.
    EXPECT_NEAR(static_cast<double>(large), 400.0, 40.0);
    EXPECT_GE(small, 32);
    EXPECT_LE(small, 64);
    EXPECT_EQ(place(scene, 1, {0.25}).first_radius, (std::vector<double>{0.25, 0.25}));
}

TEST(PointPlacement, IsTheSameForAnyNumberOfThreads) {
    const Scene scene = scene_of({square(3), box({0.3, 0.3, -0.2}, 0.4)});
    const PlacedPoints p = place(scene, 3);
    for (int threads : {1, 4}) {
        const ThreadLimit limit(threads);
        const PlacedPoints q = place(scene, 3);
        EXPECT_EQ(p.positions, q.positions);
        EXPECT_EQ(p.surfels, q.surfels);
    }
    EXPECT_NE(p.positions, place(scene, 3, {0.0, 1}).positions);
}

TEST(PointPlacement, DegenerateSurfelsDoNoHarm) {
    // Without area, as needles, at one place, tiny, and far from the origin.
    const Vec3 far{5e6, 5e6, 0};
    Surfels s = square(2, far);
    for (int k = 0; k < 3; ++k) {
        const auto index = static_cast<std::uint32_t>(s.size());
        s.positions.push_back(far);
        s.normals.push_back({0, 0, 1});
        s.radii.push_back(1.0);
        s.areas.push_back(k == 1 ? 5e-10 : 0.0);
        const Vec3 tip = far + Vec3{1, 0, 0};
        s.triangles.push_back({far, tip, k == 0 ? far : k == 1 ? tip + Vec3{0, 1e-9, 0} : tip, index});
    }
    shapes::finish(s, 0.5, 0.0);
    Surfels same = shapes::disk(far + Vec3{0, 0, 3}, {0, 0, 1}, 0.1), tiny = shapes::disk(far, {0, 0, 1}, 1e-7);
    for (int k = 0; k < 3; ++k) {
        same.positions.push_back(same.positions[0]);
        same.normals.push_back(same.normals[0]);
        same.radii.push_back(same.radii[0]);
        same.areas.push_back(same.areas[0]);
    }
    shapes::finish(same, 0.5, 0.0);
    Surfels flat = shapes::disk(far + Vec3{0, 0, 5}, {0, 0, 1}, 1.0);
    flat.areas = {0.0};
    // Edges of some roundings of their positions: they cannot be halved for long.
    Surfels hair;
    for (const double edge : {2e-9, 1e-8}) {
        const auto index = static_cast<std::uint32_t>(hair.size());
        hair.positions.push_back(far);
        hair.normals.push_back({0, 0, 1});
        hair.radii.push_back(edge);
        hair.areas.push_back(edge * edge);
        hair.triangles.push_back({far, far + Vec3{edge, 0, 0}, far + Vec3{0, edge, 0}, index});
    }
    shapes::finish(hair, 0.5, 0.0);
    const Scene scene = scene_of({s, same, tiny, flat, hair});
    const PlacedPoints p = place(scene, 3);
    expect_apart(p);
    EXPECT_GT(std::count(p.objects.begin(), p.objects.end(), 0u), 150);
    for (std::uint32_t object : {1u, 2u})
        EXPECT_EQ(std::count(p.objects.begin(), p.objects.end(), object), 1) << object;
    EXPECT_EQ(std::count(p.objects.begin(), p.objects.end(), 3u), 0);
    EXPECT_EQ(p.first_radius[3], 0.0);
    EXPECT_GE(std::count(p.objects.begin(), p.objects.end(), 4u), 1);
    // A radius larger than everything: one point for each object with an area.
    EXPECT_EQ(place(scene, 1, {100.0}).size(), 4u);
}

TEST(PointPlacement, CancelledItStaysAsItWas) {
    const Scene scene = scene_of({square(1)});
    const Tracer tracer(scene);
    PointPlacement placement(scene, tracer, {});
    placement.add_level();
    const std::vector<Vec3> before = placement.points().positions;
    std::size_t last = 0;
    EXPECT_THROW(placement.add_level({}, [&](std::size_t done, std::size_t total) { return 3 * done < total; }),
                 Cancelled);
    EXPECT_EQ(placement.points().positions, before);
    EXPECT_EQ(placement.points().level_begin.size(), 2u);
    placement.add_level({}, [&](std::size_t done, std::size_t total) {
        EXPECT_GE(done, last);
        EXPECT_LE(done, total);
        last = done;
        return true;
    });
    EXPECT_EQ(last, 1000u);
}

TEST(PointPlacement, RefusesWhatItCannotDo) {
    const Scene scene = scene_of({square(1)});
    const Tracer tracer(scene);
    EXPECT_EQ(refusal([&] { PointPlacement(scene, tracer, {-1.0}); }),
              "radius: wanted a positive number, or 0, got -1");
    PointPlacement tiny(scene, tracer, {1e-6});
    EXPECT_EQ(refusal([&] { tiny.add_level(); }),
              "radius: 1e-06 is too small for level 0 of object 0: its area 1 has room for more than 1e+09 points");
}

}  // namespace
}  // namespace surflux
