#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "refusal.h"
#include "shapes.h"
#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/neighbors/sheet_index.h"
#include "surflux/radiosity/hierarchy.h"

namespace surflux {
namespace {

using Level = Hierarchy::Level;

std::vector<std::uint32_t> one_object(const Surfels& s) { return std::vector<std::uint32_t>(s.size(), 0); }

Hierarchy built(const Surfels& s, const HierarchyOptions& options = {}) {
    return build_hierarchy(s, one_object(s), options);
}

// n surfels anywhere in the unit cube, facing anywhere, of radii and areas within a factor of ten.
Surfels random_cloud(std::size_t n, std::uint64_t seed) {
    Surfels s;
    for (std::size_t i = 0; i < n; ++i) {
        Random random(seed, i);
        s.positions.push_back({random.uniform(), random.uniform(), random.uniform()});
        const double z = 2.0 * random.uniform() - 1.0, phi = 2.0 * pi * random.uniform(), r = std::sqrt(1.0 - z * z);
        s.normals.push_back({r * std::cos(phi), r * std::sin(phi), z});
        s.radii.push_back(0.05 * std::pow(10.0, random.uniform()));
        s.areas.push_back(0.01 * std::pow(10.0, random.uniform()));
    }
    shapes::finish(s, 0.5, 0.0);
    return s;
}

// Lists and numbers say the same: every member in one group, none empty, those after the first ascending.
void expect_partition(const Level& level, std::size_t members) {
    ASSERT_EQ(level.parent_of.size(), members);
    ASSERT_EQ(level.members.size(), members);
    ASSERT_EQ(level.first.size(), level.size() + 1);
    EXPECT_EQ(level.first.front(), 0u);
    EXPECT_EQ(level.first.back(), members);
    std::vector<bool> seen(members, false);
    for (std::uint32_t g = 0; g < level.size(); ++g) {
        ASSERT_LT(level.first[g], level.first[g + 1]);
        for (std::uint32_t k = level.first[g]; k < level.first[g + 1]; ++k) {
            EXPECT_EQ(level.parent_of[level.members[k]], g);
            EXPECT_FALSE(seen[level.members[k]]);
            seen[level.members[k]] = true;
            EXPECT_TRUE(k <= level.first[g] + 1 || level.members[k - 1] < level.members[k]);
        }
    }
}

// D04 eq. 10 between what a level groups, with the member from which each group was grown.
void expect_rule(const Level& level, const std::vector<Vec3>& positions, const std::vector<Vec3>& normals,
                 const std::vector<double>& radii, double epsilon) {
    for (std::size_t g = 0; g < level.size(); ++g) {
        const std::uint32_t i = level.members[level.first[g]];
        for (std::uint32_t k = level.first[g] + 1; k < level.first[g + 1]; ++k) {
            const std::uint32_t j = level.members[k];
            EXPECT_LT(length(positions[i] - positions[j]), 2.0 * radii[i]);
            EXPECT_GT(dot(normals[i], normals[j]), epsilon);
        }
    }
}

// Averages, sums, spheres around all disks and representatives, from the surfels themselves.
void expect_figures(const Surfels& s, const Hierarchy& tree, std::size_t k) {
    const Level& level = tree.levels[k];
    const std::vector<std::uint32_t> group = tree.groups(k);
    std::vector<double> areas(level.size(), 0.0), farthest(level.size(), 0.0), nearest(level.size(), 1e30);
    std::vector<Vec3> positions(level.size());
    for (std::size_t i = 0; i < s.size(); ++i) {
        const std::uint32_t g = group[i];
        areas[g] += s.areas[i];
        positions[g] += s.areas[i] * s.positions[i];
        const Frame frame = frame_around(s.normals[i]);
        for (int a = 0; a < 32; ++a) {
            const Vec3 rim = s.radii[i] * (std::cos(pi * a / 16.0) * frame.u + std::sin(pi * a / 16.0) * frame.v);
            farthest[g] = std::max(farthest[g], length(s.positions[i] + rim - level.positions[g]));
        }
        const double off = length(s.positions[i] - level.positions[g]) / level.radii[g];
        const double score = off * off + length_squared(s.normals[i] - level.normals[g]);
        nearest[g] = std::min(nearest[g], score);
    }
    for (std::size_t g = 0; g < level.size(); ++g) {
        EXPECT_NEAR(level.areas[g], areas[g], 1e-12 * areas[g]);
        EXPECT_LT(length(level.positions[g] - positions[g] / areas[g]), 1e-12);
        EXPECT_NEAR(length(level.normals[g]), 1.0, 1e-12);
        EXPECT_LE(farthest[g], level.radii[g] * (1.0 + 1e-12));
        EXPECT_GE(farthest[g], level.radii[g] * 0.98);  // 32 points of each rim miss its farthest by 1/200 or so
        const std::uint32_t i = level.representatives[g];
        EXPECT_EQ(group[i], g);
        const double off = length(s.positions[i] - level.positions[g]) / level.radii[g];
        EXPECT_DOUBLE_EQ(off * off + length_squared(s.normals[i] - level.normals[g]), nearest[g]);
    }
    EXPECT_NEAR(std::accumulate(level.areas.begin(), level.areas.end(), 0.0),
                std::accumulate(s.areas.begin(), s.areas.end(), 0.0), 1e-9);
}

void expect_all(const Surfels& s, const Hierarchy& tree, double epsilon) {
    expect_partition(tree.levels[0], s.size());
    expect_rule(tree.levels[0], s.positions, s.normals, s.radii, epsilon);
    for (std::size_t k = 1; k < tree.levels.size(); ++k) {
        const Level& below = tree.levels[k - 1];
        expect_partition(tree.levels[k], below.size());
        expect_rule(tree.levels[k], below.positions, below.normals, below.radii, epsilon);
        EXPECT_LE(static_cast<double>(tree.levels[k].size()), 0.95 * static_cast<double>(below.size()));
    }
    for (std::size_t k = 0; k < tree.levels.size(); ++k) expect_figures(s, tree, k);
}

TEST(Hierarchy, GroupsAsTheRuleSays) {
    const Surfels sphere = shapes::sphere(2000, 0.8, 1.0, 0.5, 0.0, {5, 6, 7});
    const Hierarchy of_sphere = built(sphere);
    EXPECT_GE(of_sphere.levels.size(), 3u);
    expect_all(sphere, of_sphere, 0.8);
    for (const double epsilon : {-0.5, 0.3, 0.95}) {
        const Surfels cloud = random_cloud(1500, 3);
        HierarchyOptions options;
        options.epsilon = epsilon;
        expect_all(cloud, built(cloud, options), epsilon);
    }
}

TEST(Hierarchy, LeavesNothingOutThatTheRuleTakes) {
    // Grown one after the other, no member of a later group was free to join an earlier one: of any two seeds, the one
    // that came first did not reach the other. So one of the two directions of eq. 10 fails for every pair of seeds.
    const Surfels s = random_cloud(800, 5);
    HierarchyOptions options;
    options.epsilon = 0.2;
    const Level level = built(s, options).levels[0];
    for (std::size_t g = 0; g < level.size(); ++g)
        for (std::size_t h = 0; h < g; ++h) {
            const std::uint32_t i = level.members[level.first[g]], j = level.members[level.first[h]];
            const double apart = length(s.positions[i] - s.positions[j]);
            const bool both = apart < 2.0 * std::min(s.radii[i], s.radii[j]);
            EXPECT_FALSE(both && dot(s.normals[i], s.normals[j]) > 0.2) << i << " " << j;
        }
}

TEST(Hierarchy, IsTheSameForAnyNumberOfThreadsAndAnotherForAnotherSeed) {
    const Surfels s = random_cloud(5000, 1);
    HierarchyOptions options;
    options.epsilon = 0.3;
    const Hierarchy many = built(s, options);
    const ThreadLimit limit(1);
    const Hierarchy one = built(s, options);
    ASSERT_EQ(many.levels.size(), one.levels.size());
    for (std::size_t k = 0; k < one.levels.size(); ++k) {
        EXPECT_EQ(many.levels[k].members, one.levels[k].members);
        EXPECT_EQ(many.levels[k].positions, one.levels[k].positions);
        EXPECT_EQ(many.levels[k].radii, one.levels[k].radii);
    }
    options.seed = 1;
    EXPECT_NE(built(s, options).levels[0].members, one.levels[0].members);
}

TEST(Hierarchy, HasAsManyLevelsAsAskedFor) {
    const Surfels s = shapes::sphere(2000, 0.8, 1.0, 0.5, 0.0);
    const Hierarchy all = built(s);
    HierarchyOptions options;
    options.max_levels = 2;
    const Hierarchy two = built(s, options);
    ASSERT_EQ(two.levels.size(), 2u);
    EXPECT_EQ(two.levels[1].members, all.levels[1].members);
    EXPECT_EQ(two.groups(1), all.groups(1));
}

TEST(Hierarchy, APlaneComesToOneGroup) {
    Surfels s;
    shapes::add_rectangle(s, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 30, 30);
    shapes::finish(s, 0.5, 0.0);
    const Hierarchy tree = built(s);
    const Level& top = tree.levels.back();
    ASSERT_EQ(top.size(), 1u);
    EXPECT_LT(length(top.positions[0] - Vec3{0.5, 0.5, 0.0}), 1e-12);
    EXPECT_NEAR(top.radii[0], std::sqrt(0.5), 0.01);  // disks reach a little beyond the corners
    EXPECT_LT(length(s.positions[top.representatives[0]] - Vec3{0.5, 0.5, 0.0}), 0.03);
}

TEST(Hierarchy, KeepsObjectsAndSidesApart) {
    Surfels s = two_sided(shapes::sphere(300, 1.0, 1.0, 0.5, 0.0));
    const std::size_t n = s.size();
    std::vector<std::uint32_t> twice(n);
    std::iota(twice.begin(), twice.end(), 0u);
    twice.insert(twice.end(), twice.begin(), twice.begin() + 600);
    s = select(s, twice);
    std::vector<std::uint32_t> object(s.size(), 7);
    std::fill(object.begin() + static_cast<std::ptrdiff_t>(n), object.end(), 3);
    const Hierarchy tree = build_hierarchy(s, object, {});
    for (std::size_t k = 0; k < tree.levels.size(); ++k) {
        const std::vector<std::uint32_t> group = tree.groups(k);
        std::set<std::uint32_t> of[2];
        for (std::size_t i = 0; i < s.size(); ++i) {
            of[i < n].insert(group[i]);
            EXPECT_TRUE(i % n >= 300 || group[i] != group[i + 300]) << "both sides of a sheet";
        }
        for (std::uint32_t g : of[0]) EXPECT_EQ(of[1].count(g), 0u);
    }
}

TEST(Hierarchy, TakesDegenerateClouds) {
    const Hierarchy one = built(shapes::disk({1, 2, 3}, {0, 0, 1}, 0.5));
    ASSERT_EQ(one.levels.size(), 1u);
    EXPECT_EQ(one.levels[0].size(), 1u);
    EXPECT_DOUBLE_EQ(one.levels[0].radii[0], 0.5);

    // 30 000 in one place, facing the same way: one group. Facing anywhere, or where each reaches all: groups by
    // normals alone, and what takes the square of the number does not end here.
    Surfels s = random_cloud(30'000, 2);
    s.positions.assign(s.size(), {1e6, 1e6, 1e6});
    HierarchyOptions fine;
    fine.epsilon = 0.9999;
    const Hierarchy by_normals = built(s, fine);
    expect_partition(by_normals.levels[0], s.size());
    expect_rule(by_normals.levels[0], s.positions, s.normals, s.radii, fine.epsilon);
    EXPECT_GT(by_normals.levels[0].size(), 2000u);
    s = random_cloud(30'000, 2);
    s.radii.assign(s.size(), 1e30);
    s.radii[5] = 1e-30;
    expect_rule(built(s, fine).levels[0], s.positions, s.normals, s.radii, fine.epsilon);
    s.positions.assign(s.size(), {0, 0, 0});
    s.normals.assign(s.size(), {0, 0, 1});
    EXPECT_EQ(built(s).levels[0].size(), 1u);

    s.areas.assign(s.size(), 0.0);  // plain averages
    EXPECT_EQ(built(s).levels[0].normals[0], (Vec3{0, 0, 1}));
}

TEST(Hierarchy, OppositeNormalsDoNotCancel) {
    Surfels s = two_sided(shapes::disk({0, 0, 0}, {0, 1, 0}, 1.0));
    s.normals[1] = normalized({1e-9, -1.0, 0.3});
    s.areas = {1.0, 1.0};
    HierarchyOptions options;
    options.epsilon = -0.99;
    const Hierarchy tree = built(s, options);
    ASSERT_EQ(tree.levels.back().size(), 1u);
    EXPECT_NEAR(length(tree.levels.back().normals[0]), 1.0, 1e-12);
}

TEST(Hierarchy, KeepsDigitsInSurveyCoordinates) {
    Surfels s = shapes::sphere(500, 1.0, 1.0, 0.5, 0.0);
    const Hierarchy here = built(s);
    for (Vec3& p : s.positions) p += Vec3{5e6, 5e6, 0};
    const Hierarchy there = built(s);
    const Vec3 moved = there.levels[0].positions[0] - here.levels[0].positions[0];
    EXPECT_LT(length(moved - Vec3{5e6, 5e6, 0}), 1e-8);
}

TEST(Hierarchy, RefusesWhatItCannotGroup) {
    Surfels s = shapes::disk({0, 0, 0}, {0, 0, 1}, 1.0);
    EXPECT_EQ(refusal([&] { build_hierarchy({}, {}, {}); }), "surfels: there are none to group");
    EXPECT_EQ(refusal([&] { build_hierarchy(s, {0, 0}, {}); }), "object: wanted a number for each of 1 surfels, got 2");
    EXPECT_EQ(refusal([&] { built(s, {1.0, 0, 0}); }), "epsilon: wanted a number in (-1, 1), got 1");
    EXPECT_EQ(refusal([&] { built(s, {0.8, -1, 0}); }), "max_levels: wanted at least 0, got -1");
    EXPECT_EQ(refusal([&] { built(s).groups(1); }), "level: wanted below 1, got 1");
    s.radii[0] = 0.0;
    EXPECT_EQ(refusal([&] { built(s); }), "radii: wanted above 0, got 0 at index 0");
    s.areas.clear();
    EXPECT_EQ(refusal([&] { built(s); }), "areas: wanted one for each of 1 surfels, got 0");
}

TEST(Hierarchy, StopsWhenToldTo) {
    const Surfels s = random_cloud(20'000, 1);
    int calls = 0;
    const Progress stop = [&](std::size_t done, std::size_t total) {
        EXPECT_LE(done, total);
        return ++calls < 3;
    };
    HierarchyOptions options;
    options.epsilon = 0.9;
    EXPECT_THROW(build_hierarchy(s, one_object(s), options, stop), Cancelled);
    EXPECT_EQ(calls, 3);
}

TEST(SheetIndex, TakesWhatALoopOverAllWouldTake) {
    const Surfels s = random_cloud(1000, 9);
    std::vector<double> reach(s.radii);
    for (double& r : reach) r *= 2.0;
    const std::vector<std::uint32_t> group(s.size(), 0);
    SheetIndex index(s.positions, s.normals, reach, group, 0.3);
    std::vector<bool> gone(s.size(), false);
    for (std::uint32_t i : {17u, 400u, 3u, 999u, 500u, 0u}) {
        std::vector<std::uint32_t> expected, found;
        for (std::uint32_t j = 0; j < s.size(); ++j) {
            const bool near = length(s.positions[i] - s.positions[j]) < reach[i];
            if (gone[j] || !(near && dot(s.normals[i], s.normals[j]) > 0.3)) continue;
            expected.push_back(j);
            gone[j] = true;
        }
        index.take(i, found);
        std::sort(found.begin(), found.end());
        EXPECT_EQ(found, expected);
        EXPECT_TRUE(index.is_taken(i));
    }
}

}  // namespace
}  // namespace surflux
