#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "shapes.h"
#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/neighbors/normals.h"
#include "surflux/neighbors/orientation.h"
#include "surflux/trace/inward.h"

namespace surflux {
namespace {

// Share of the normals within 20 degrees of the truth, sign included.
double share_right(const std::vector<Vec3>& found, const std::vector<Vec3>& truth) {
    std::size_t right = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) right += dot(found[i], truth[i]) > std::cos(20.0 * pi / 180.0);
    return static_cast<double>(right) / static_cast<double>(truth.size());
}

struct Cloud {
    std::vector<Vec3> points, normals;
    void add(const Vec3& p, const Vec3& n) {
        points.push_back(p);
        normals.push_back(n);
    }
};

Vec3 random_direction(Random& random) {
    const double z = 2.0 * random.uniform() - 1.0, phi = 2.0 * pi * random.uniform(), r = std::sqrt(1.0 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
}

double normal_deviate(Random& random) {
    return std::sqrt(-2.0 * std::log(1.0 - random.uniform())) * std::cos(2.0 * pi * random.uniform());
}

// A spherical shell: n random points on the outside and n on the inside, `gap` mean spacings below.
Cloud shell(std::size_t n, double gap, double noise) {
    Random random(1);
    const double spacing = std::sqrt(4.0 * pi / static_cast<double>(n));
    Cloud out;
    for (std::size_t i = 0; i < 2 * n; ++i) {
        const Vec3 d = random_direction(random);
        const Vec3 jitter{normal_deviate(random), normal_deviate(random), normal_deviate(random)};
        const bool inside = i % 2 == 1;
        out.add((inside ? 1.0 - gap * spacing : 1.0) * d + noise * spacing * jitter, inside ? -d : d);
    }
    return out;
}

TEST(Agreement, IsThatOfAnArcAndOfTheTwoSidesOfAPlate) {
    for (double angle = 0.1; angle < 3.1; angle += 0.1) {
        const Vec3 n{0, 0, 1}, m{std::sin(angle), 0, std::cos(angle)};
        EXPECT_NEAR(agreement(n, m, m - n), 1.0, 1e-12);  // on a sphere n is at n, m at m
        EXPECT_NEAR(agreement(n, -m, m - n), -1.0, 1e-12);
    }
    EXPECT_DOUBLE_EQ(agreement({0, 0, 1}, {0, 0, -1}, {0, 0, -0.1}), 1.0);
    EXPECT_DOUBLE_EQ(agreement({0, 0, 1}, {0, 0, 1}, {0, 0, -0.1}), -1.0);
    EXPECT_DOUBLE_EQ(agreement({0, 0, 1}, {0, 0, 1}, {1, 0, 0}), 1.0);
}

TEST(Normals, SurviveSheetsOneSpacingApart) {
    for (const double gap : {2.0, 1.5, 1.0, 0.7}) {
        const Cloud cloud = shell(2500, gap, 0.0);
        EXPECT_GT(share_right(estimate_normals(cloud.points, {}), cloud.normals), 0.98) << gap;
    }
}

TEST(Normals, SurviveNoise) {
    // A fifth of the mean spacing, in all directions.
    Cloud cloud = shell(5000, 0.5, 0.2);
    Cloud outer;
    for (std::size_t i = 0; i < cloud.points.size(); i += 2) outer.add(cloud.points[i], cloud.normals[i]);
    EXPECT_GT(share_right(estimate_normals(outer.points, {}), outer.normals), 0.975);
}

TEST(Normals, SurviveScanLines) {
    // A scanner turns in a room: eight times as many points along a line as across.
    const Vec3 low{-5, -3, -1.5}, high{7, 4, 1.7};
    Random random(2);
    Cloud cloud;
    for (int line = -15; line < 15; ++line)
        for (int k = 0; k < 1440; ++k) {
            const double e = (line + 0.5) * pi / 90.0, a = k * pi / 720.0;
            const Vec3 d{std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
            double distance = 1e9;
            Vec3 n;
            for (int axis = 0; axis < 3; ++axis) {
                const double t = (d[axis] > 0.0 ? high : low)[axis] / d[axis];
                if (!(t > 0.0 && t < distance)) continue;
                distance = t;
                n = {};
                n[axis] = d[axis] > 0.0 ? -1.0 : 1.0;
            }
            cloud.add(distance * (1.0 + 5e-4 * normal_deviate(random)) * d, n);
        }
    NormalOptions options;
    options.viewpoint = Vec3{};
    EXPECT_GT(share_right(estimate_normals(cloud.points, options), cloud.normals), 0.85);
}

TEST(Normals, AreSharpBesideAnEdge) {
    const Surfels cube = shapes::cube_inside(20, 0.5, 0.0);
    std::vector<Vec3> outward = cube.normals;
    for (Vec3& n : outward) n = -n;
    const std::vector<Vec3> found = estimate_normals(cube.positions, {});
    for (std::size_t i = 0; i < outward.size(); ++i) {
        const Vec3 d = cube.positions[i] - Vec3{0.5, 0.5, 0.5};
        int far = 0;  // the coordinates within 1.5 rows of a face
        for (int axis = 0; axis < 3; ++axis) far += std::abs(d[axis]) > 0.5 - 1.5 / 20.0;
        EXPECT_GT(dot(found[i], outward[i]), far == 1 ? 0.9999 : 0.5) << i;
    }
}

TEST(Normals, DoNotDependOnThreadsNorOnAnOffset) {
    const Cloud cloud = shell(1500, 1.0, 0.05);
    const std::vector<Vec3> all = estimate_normals(cloud.points, {});
    {
        const ThreadLimit one(1);
        EXPECT_EQ(estimate_normals(cloud.points, {}), all);
    }
    std::vector<Vec3> moved = cloud.points;
    for (Vec3& p : moved) p += Vec3{5e6, -5e6, 5e6};
    const std::vector<Vec3> there = estimate_normals(moved, {});
    for (std::size_t i = 0; i < all.size(); ++i) EXPECT_GT(dot(there[i], all[i]), 0.999);
}

TEST(Normals, ThoseWantedAreAsOfAll) {
    const Cloud cloud = shell(3000, 1.0, 0.05);
    std::vector<Vec3> points = cloud.points;
    points.push_back(points[0]);  // wanted where it coincides with one that is not
    NormalOptions options;
    for (std::size_t i = 0; i < points.size(); ++i) options.wanted.push_back(i % 4 == 1 || i + 1 == points.size());
    const std::vector<Vec3> all = estimate_normals(points, {}), some = estimate_normals(points, options);
    std::size_t different = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_TRUE(!options.wanted[i] || some[i] == all[i]) << i;
        different += !(some[i] == all[i]);
    }
    EXPECT_GT(different, 100u);  // of which the second fit is spared
    options.wanted.pop_back();
    EXPECT_THROW(estimate_normals(points, options), ArgumentError);
}

TEST(Normals, AreCancelledBesideTheirTwoFitsToo) {
    // Distances to neighbours come before the first fit, the spanning tree between the two: each takes as long as one,
    // so each has to ask, more than the once that a fit begins or ends with.
    const Cloud cloud = shell(50'000, 3.0, 0.0);
    std::size_t before = 0, between = 0;
    estimate_normals(cloud.points, {}, [&](std::size_t done, std::size_t total) {
        before += done == 0;
        between += 2 * done == total;
        return true;
    });
    EXPECT_GE(before, 3u);
    EXPECT_GE(between, 5u);
    for (const std::size_t at : {std::size_t{0}, cloud.points.size()}) {
        std::size_t asked = 0;
        EXPECT_THROW(estimate_normals(cloud.points, {},
                                      [&](std::size_t done, std::size_t) { return done != at || ++asked < 2; }),
                     Cancelled);
    }
}

Surfels surfels_of(const Cloud& cloud) {
    Surfels s;
    s.positions = cloud.points;
    s.normals = cloud.normals;
    s.radii = estimate_radii(s.positions);
    shapes::finish(s, 0.5, 0.0);
    return s;
}

Cloud ball(std::size_t n, double lowest) {
    Cloud out;
    const Surfels s = shapes::sphere(n, 1.0, 1.0, 0.5, 0.0);
    for (std::size_t i = 0; i < n; ++i)
        if (s.positions[i].z > lowest) out.add(s.positions[i], s.normals[i]);
    return out;
}

TEST(InwardPatches, AreFoundExactlyOnAClosedBodyWhateverTheirShare) {
    for (const double height : {2.0, 0.9, 0.0, -0.9, -2.0}) {
        Cloud cloud = ball(3000, -2.0);
        std::size_t turned = 0;
        for (std::size_t i = 0; i < cloud.points.size(); ++i)
            if (cloud.points[i].z > height) cloud.normals[i] = -cloud.normals[i], ++turned;
        const std::vector<std::uint32_t> patch = inward_patches(surfels_of(cloud), {}).patch;
        for (std::size_t i = 0; i < patch.size(); ++i) EXPECT_EQ(patch[i], cloud.points[i].z > height ? 1u : 0u);
        EXPECT_EQ(std::count(patch.begin(), patch.end(), 1u), static_cast<long>(turned));
    }
}

TEST(InwardPatches, OfAnOpenScanAreThoseAgainstItsGreaterPart) {
    Cloud cloud = ball(4000, 0.7);
    const std::vector<std::uint32_t> right = inward_patches(surfels_of(cloud), {}).patch;
    EXPECT_EQ(std::count(right.begin(), right.end(), 0u), static_cast<long>(right.size()));
    // Facing into the bowl as a whole is no mistake: nobody knows better.
    Cloud bowl = cloud;
    for (Vec3& n : bowl.normals) n = -n;
    const std::vector<std::uint32_t> inside = inward_patches(surfels_of(bowl), {}).patch;
    EXPECT_EQ(std::count(inside.begin(), inside.end(), 0u), static_cast<long>(inside.size()));
    for (std::size_t i = 0; i < cloud.points.size(); ++i)
        if (cloud.points[i].z > 0.95) cloud.normals[i] = -cloud.normals[i];
    const std::vector<std::uint32_t> patch = inward_patches(surfels_of(cloud), {}).patch;
    for (std::size_t i = 0; i < patch.size(); ++i) EXPECT_EQ(patch[i], cloud.points[i].z > 0.95 ? 1u : 0u);
}

TEST(InwardPatches, AreNumberedFromTheLargest) {
    Cloud cloud = ball(3000, -2.0);
    for (std::size_t i = 0; i < cloud.points.size(); ++i)
        if (cloud.points[i].z > 0.9 || cloud.points[i].z < -0.7) cloud.normals[i] = -cloud.normals[i];
    cloud.normals[1500] = -cloud.normals[1500];  // alone: noise
    const std::vector<std::uint32_t> patch = inward_patches(surfels_of(cloud), {}).patch;
    for (std::size_t i = 0; i < patch.size(); ++i)
        EXPECT_EQ(patch[i], cloud.points[i].z < -0.7 ? 1u : cloud.points[i].z > 0.9 ? 2u : 0u);
}

TEST(InwardPatches, AreNotSeenInTwoSidedSheetsNorInFewSurfels) {
    const Surfels two = two_sided(surfels_of(ball(500, -2.0)));
    for (std::uint32_t p : inward_patches(two, {}).patch) EXPECT_EQ(p, 0u);
    EXPECT_EQ(inward_patches(shapes::disk({}, {0, 0, 1}, 1.0), {}).patch, std::vector<std::uint32_t>{0});
}

TEST(InwardPatches, StopWhenTold) {
    EXPECT_THROW(inward_patches(surfels_of(ball(500, -2.0)), {}, [](std::size_t, std::size_t) { return false; }),
                 Cancelled);
}

}  // namespace
}  // namespace surflux
