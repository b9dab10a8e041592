#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "shapes.h"
#include "surflux/radiosity/surfel_tree.h"

namespace surflux {
namespace {

using shapes::scene_of;

constexpr std::uint32_t none = SurfelTree::none;

Scene ball_and_room() {
    return scene_of({shapes::sphere(300, 0.3, 1.0, 0.5, 0.0, {0.5, 0.5, 0.5}), shapes::cube_inside(5, 0.5, 0.0)});
}

Hierarchy hierarchy_of(const Scene& scene) { return build_hierarchy(scene.surfels, scene.object, {}); }

// Four around a surfel, half its radius away.
std::uint32_t split(SurfelTree& tree, std::uint32_t leaf) {
    const Frame frame = frame_around(tree.normal(leaf));
    SurfelTree::Child below[SurfelTree::children];
    for (std::size_t k = 0; k < 4; ++k) {
        const double angle = 0.25 * pi + 0.5 * pi * static_cast<double>(k), r = 0.4 * tree.radius(leaf);
        below[k] = {tree.position(leaf) + (r * std::cos(angle)) * frame.u + (r * std::sin(angle)) * frame.v,
                    tree.normal(leaf), tree.reflectance(leaf)};
    }
    return tree.split(leaf, below);
}

// Every leaf below a node, once each.
std::vector<std::uint32_t> leaves_below(const SurfelTree& tree, std::uint32_t node) {
    if (tree.is_leaf(node)) return {node};
    std::vector<std::uint32_t> out;
    tree.for_members(node, [&](std::uint32_t member) {
        for (std::uint32_t leaf : leaves_below(tree, member)) out.push_back(leaf);
    });
    return out;
}

double sum_of(const SurfelTree& tree, const std::vector<std::uint32_t>& nodes) {
    double sum = 0.0;
    for (std::uint32_t node : nodes) sum += tree.area(node);
    return sum;
}

TEST(SurfelTree, EveryLevelPartitionsTheSurfels) {
    const Scene scene = ball_and_room();
    const SurfelTree tree(scene, hierarchy_of(scene), 0);
    const std::size_t n = scene.surfels.size();
    EXPECT_EQ(tree.points(), n);
    EXPECT_EQ(tree.leaves(), n);
    EXPECT_FALSE(tree.has_room());
    std::set<std::pair<std::uint32_t, std::uint32_t>> levels;
    for (std::size_t count : {1u, 5u, 20u, 60u, 1000000u}) levels.insert(tree.level_of_at_least(count));
    EXPECT_GE(levels.size(), 3u);
    double whole = 0.0;
    for (double area : scene.surfels.areas) whole += area;
    for (const auto& [from, to] : levels) {
        std::set<std::uint32_t> seen;
        double area = 0.0;
        for (std::uint32_t node = from; node < to; ++node) {
            const std::vector<std::uint32_t> leaves = leaves_below(tree, node);
            EXPECT_NEAR(sum_of(tree, leaves), tree.area(node), 1e-12 * whole);
            EXPECT_NE(std::find(leaves.begin(), leaves.end(), tree.representative(node)), leaves.end());
            for (std::uint32_t leaf : leaves) EXPECT_TRUE(seen.insert(leaf).second);
            area += tree.area(node);
        }
        EXPECT_EQ(seen.size(), n);
        EXPECT_NEAR(area, whole, 1e-12 * whole);
    }
    EXPECT_EQ(tree.level_of_at_least(1000000), std::make_pair(0u, static_cast<std::uint32_t>(n)));
}

TEST(SurfelTree, SplitsReplaceALeafByFourAndKeepItsArea) {
    const Scene scene = ball_and_room();
    const std::size_t n = scene.surfels.size();
    SurfelTree tree(scene, hierarchy_of(scene), n + 20);
    double whole = 0.0;
    for (double area : scene.surfels.areas) whole += area;
    const std::uint32_t first = split(tree, 7), second = split(tree, first + 2), third = split(tree, 9);
    EXPECT_EQ(tree.leaves(), n + 9);
    EXPECT_EQ(tree.points(), n + 12);
    EXPECT_FALSE(tree.is_leaf(7));
    EXPECT_TRUE(tree.is_leaf(first));
    EXPECT_FALSE(tree.is_leaf(first + 2));
    EXPECT_EQ(tree.first_child(7), first);
    EXPECT_EQ(tree.first_child(first), none);
    for (std::uint32_t k = 0; k < 4; ++k) {
        EXPECT_EQ(tree.area(first + k), 0.25 * tree.area(7));
        EXPECT_EQ(tree.radius(first + k), 0.5 * tree.radius(7));
        EXPECT_EQ(tree.radius(second + k), 0.25 * tree.radius(7));
        EXPECT_EQ(tree.surfel(second + k), 7u);
        EXPECT_EQ(tree.surfel(third + k), 9u);
        EXPECT_EQ(tree.object(second + k), scene.object[7]);
        EXPECT_TRUE(tree.is_inserted(third + k));
    }
    // Leaves: those of one surfel after those of the one before, all of them, once; areas as they were.
    const std::vector<std::uint32_t> leaves = tree.all_leaves();
    EXPECT_EQ(leaves.size(), tree.leaves());
    EXPECT_EQ(std::set<std::uint32_t>(leaves.begin(), leaves.end()).size(), leaves.size());
    for (std::size_t k = 0; k + 1 < leaves.size(); ++k) EXPECT_LE(tree.surfel(leaves[k]), tree.surfel(leaves[k + 1]));
    EXPECT_NEAR(sum_of(tree, leaves), whole, 1e-12 * whole);
    EXPECT_NEAR(sum_of(tree, leaves_below(tree, 7)), tree.area(7), 1e-14 * whole);
    const Surfels at = tree.surfels_at(leaves);
    ASSERT_EQ(at.size(), leaves.size());
    for (std::size_t k = 0; k < leaves.size(); ++k) {
        EXPECT_EQ(at.areas[k], tree.area(leaves[k]));
        EXPECT_EQ(length(at.positions[k] - tree.position(leaves[k])), 0.0);
    }
    double triangles = 0.0;
    for (const Triangle& t : at.triangles) triangles += area_of(t);
    EXPECT_NEAR(triangles, 6.0, 1e-12);  // those of the room are all there
}

TEST(SurfelTree, RoomIsForWholeFamiliesOnly) {
    const Scene scene = ball_and_room();
    const std::size_t n = scene.surfels.size();
    for (std::size_t room : {0u, 1u, 2u, 3u, 5u, 6u}) {
        SurfelTree tree(scene, hierarchy_of(scene), n + room);
        std::uint32_t leaf = 0;
        while (tree.has_room()) split(tree, leaf++);
        EXPECT_EQ(tree.leaves(), n + room / 3 * 3);
        EXPECT_LE(tree.points(), tree.size());
    }
}

TEST(SurfelTree, WhatGroupsSendIsTheMeanOfTheirLeavesByArea) {
    const Scene scene = ball_and_room();
    SurfelTree tree(scene, hierarchy_of(scene), scene.surfels.size() + 30);
    split(tree, split(tree, 3) + 1);
    split(tree, 310);
    std::vector<double> values(tree.size() * 2, 0.0);
    for (const std::uint32_t p : tree.all_leaves()) {
        values[2 * p] = std::sin(static_cast<double>(p));
        values[2 * p + 1] = 1.0;
    }
    tree.pull_up(values, 2);
    const auto check = [&](std::uint32_t node) {
        double sum = 0.0, area = 0.0;
        for (std::uint32_t leaf : leaves_below(tree, node)) {
            sum += tree.area(leaf) * values[2 * leaf];
            area += tree.area(leaf);
        }
        EXPECT_NEAR(values[2 * node], sum / area, 1e-12);
        EXPECT_NEAR(values[2 * node + 1], 1.0, 1e-12);
    };
    check(3);
    check(310);
    for (std::size_t count : {1u, 20u, 60u}) {
        const auto [from, to] = tree.level_of_at_least(count);
        for (std::uint32_t node = from; node < to; ++node) check(node);
    }
}

TEST(SurfelTree, SendersAreAsLargeAsTheConeCovers) {
    const Scene scene = ball_and_room();
    SurfelTree tree(scene, hierarchy_of(scene), scene.surfels.size() + 30);
    const std::uint32_t child = split(tree, 12), below = split(tree, child + 3);
    // A cone of no width: the leaf there.
    for (std::uint32_t k = 0; k < 3; ++k) EXPECT_EQ(tree.sender(12, tree.position(child + k), 0.0), child + k);
    for (std::uint32_t k = 0; k < 4; ++k) EXPECT_EQ(tree.sender(12, tree.position(below + k), 0.0), below + k);
    // As wide as a surfel, the surfel; wider, groups that hold it, larger and larger.
    EXPECT_EQ(tree.sender(12, tree.position(12), 1.01 * tree.radius(12)), 12u);
    double before = tree.area(12);
    bool grew = false;
    for (double reach = 2 * tree.radius(12); reach < 4.0; reach *= 1.5) {
        const std::uint32_t node = tree.sender(12, tree.position(12), reach);
        EXPECT_GE(tree.area(node), before);
        grew = grew || tree.area(node) > before;
        before = tree.area(node);
        const std::vector<std::uint32_t> leaves = leaves_below(tree, node);
        EXPECT_TRUE(std::any_of(leaves.begin(), leaves.end(), [&](std::uint32_t p) { return tree.surfel(p) == 12; }));
        for (std::uint32_t leaf : leaves) {
            EXPECT_LE(length(tree.position(leaf) - tree.position(12)), 2 * reach);
            EXPECT_EQ(tree.object(leaf), tree.object(12));
        }
    }
    EXPECT_TRUE(grew);
}

TEST(SurfelTree, PartsOfAPatchAreItsCells) {
    const Scene scene = scene_of({shapes::cube_inside(2, 0.5, 0.0)});
    SurfelTree tree(scene, hierarchy_of(scene), 2 * scene.surfels.size());
    const std::uint32_t first = split(tree, 4);
    tree.move(first, tree.position(4) + 0.9 * (tree.position(first) - tree.position(4)));
    tree.share_patch(4);
    const std::uint32_t second = split(tree, first);
    tree.share_patch(first);
    double sum = 0.0;
    for (std::uint32_t leaf : leaves_below(tree, 4)) {
        double own = 0.0;
        for (const Triangle& t : tree.piece(leaf)) own += area_of(t);
        EXPECT_NEAR(own, tree.area(leaf), 1e-14);
        EXPECT_GT(own, 0.0);
        sum += own;
    }
    EXPECT_NEAR(sum, tree.area(4), 1e-14);
    EXPECT_GE(second, first + 4);
}

}  // namespace
}  // namespace surflux
