#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "shapes.h"
#include "surflux/radiosity/insertion.h"

namespace surflux {
namespace {

using shapes::scene_of;

// A tree with room, refined where a field says so.
struct Refined {
    Scene scene;
    SurfelTree tree;
    Insertion insertion;

    Refined(Scene of, std::size_t most, double least_share = 0.0)
        : scene(std::move(of)),
          tree(scene, build_hierarchy(scene.surfels, scene.object, {}), most),
          insertion(tree, {least_share * scene.surfels.radii[0]}) {}

    template <class Field>
    int refine(const Field& field, double wanted, int rounds) {
        int done = 0;
        while (done < rounds && insertion.refine([&](std::uint32_t p) { return field(tree.position(p)); },
                                                 [&](std::uint32_t) { return wanted; }))
            ++done;
        return done;
    }
    std::vector<std::uint32_t> leaves() const { return tree.all_leaves(); }
    double leaf_area() const {
        double sum = 0.0;
        for (std::uint32_t p : leaves()) sum += tree.area(p);
        return sum;
    }
};

double total(const std::vector<double>& areas) {
    double sum = 0.0;
    for (double area : areas) sum += area;
    return sum;
}

Scene grid_of_points(int n) {
    Surfels s;
    for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) {
            s.positions.push_back({(a + 0.5) / n, (b + 0.5) / n, 0.0});
            s.normals.push_back({0, 0, 1});
        }
    shapes::finish(s, 0.5, 0.0);
    s.radii.assign(s.size(), 0.75 / n);
    s.areas.assign(s.size(), 1.0 / (n * n));
    return scene_of({s});
}

Scene grid_of_patches(int n) {
    Surfels s;
    shapes::add_rectangle(s, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, n, n);
    shapes::finish(s, 0.5, 0.0);
    return scene_of({s});
}

double step(const Vec3& p) { return p.x + 0.3 * p.y < 0.61 ? 1.0 : 0.0; }

TEST(Insertion, AreasAreKept) {
    for (Scene scene : {grid_of_points(12), grid_of_patches(12), scene_of({shapes::sphere(400, 0.8, 1.0, 0.5, 0.0)})}) {
        const double before = total(scene.surfels.areas);
        Refined r(std::move(scene), 4000);
        EXPECT_GE(r.refine(step, 0.1, 3), 2);
        EXPECT_GT(r.tree.leaves(), r.scene.surfels.size() + 30);
        EXPECT_NEAR(r.leaf_area(), before, 1e-12 * before);
        // Of each surfel by itself, too.
        std::vector<double> of(r.scene.surfels.size(), 0.0);
        for (std::uint32_t p : r.leaves()) of[r.tree.surfel(p)] += r.tree.area(p);
        for (std::size_t i = 0; i < of.size(); ++i) EXPECT_NEAR(of[i], r.scene.surfels.areas[i], 1e-12 * before);
    }
}

TEST(Insertion, SplitsWhereTheFieldBreaksAndNowhereElse) {
    Refined r(grid_of_points(20), 4000);
    r.refine(step, 0.1, 3);
    for (std::uint32_t p : r.leaves())
        if (r.tree.is_inserted(p)) {
            EXPECT_LT(std::abs(r.tree.position(p).x + 0.3 * r.tree.position(p).y - 0.61), 0.15);
        }
    // Splitting halves what is off beside the break: the smallest are nearest to it.
    double nearest = 1e300, smallest = 1e300;
    for (std::uint32_t p : r.leaves()) {
        const double distance = std::abs(r.tree.position(p).x + 0.3 * r.tree.position(p).y - 0.61);
        if (r.tree.radius(p) < 0.13 * 0.75 / 20) smallest = std::min(smallest, distance);
        nearest = std::min(nearest, distance);
    }
    EXPECT_LT(smallest, 0.01);
    EXPECT_LT(nearest, 0.005);
}

TEST(Insertion, ASlopeIsNoError) {
    // D04 eq. 11 alone would refine all of a field that rises evenly; it is interpolated to first order.
    Refined r(grid_of_points(20), 4000);
    const auto slope = [](const Vec3& p) { return 1.0 + 2.0 * p.x - 3.0 * p.y; };
    EXPECT_EQ(r.refine(slope, 0.03, 3), 0);
    EXPECT_EQ(r.tree.leaves(), 400u);
    EXPECT_EQ(r.refine([](const Vec3&) { return 7.0; }, 1e-9, 3), 0);
}

TEST(Insertion, ChildrenHaveHalfTheRadiusAndStayBesideTheirParent) {
    Refined r(grid_of_points(12), 4000);
    r.refine(step, 0.1, 1);
    std::size_t families = 0;
    for (std::uint32_t i = 0; i < r.scene.surfels.size(); ++i) {
        const std::uint32_t first = r.tree.first_child(i);
        if (first == SurfelTree::none) continue;
        ++families;
        for (std::uint32_t p = first; p < first + 4; ++p) {
            EXPECT_EQ(r.tree.radius(p), 0.5 * r.tree.radius(i));
            EXPECT_EQ(r.tree.area(p), 0.25 * r.tree.area(i));
            EXPECT_EQ(r.tree.position(p).z, 0.0);
            EXPECT_LE(length(r.tree.position(p) - r.tree.position(i)), 0.75 * r.tree.radius(i) * (1 + 1e-9));
            EXPECT_NEAR(r.tree.reflectance(p).x, 0.5, 1e-12);
            EXPECT_NEAR(length(r.tree.normal(p)), 1.0, 1e-12);
        }
    }
    EXPECT_GT(families, 10u);
}

TEST(Insertion, RepulsionKeepsADistance) {
    // Children of surfels side by side would stand .2 of a spacing apart or less where their frames are turned.
    const int n = 16;
    Refined r(grid_of_points(n), 4000);
    r.refine(step, 0.1, 1);
    const std::vector<std::uint32_t> leaves = r.leaves();
    double least = 1e300, sum = 0.0;
    std::size_t count = 0;
    for (std::uint32_t p : leaves) {
        if (!r.tree.is_inserted(p)) continue;
        double nearest = 1e300;
        for (std::uint32_t q : leaves)
            if (q != p) nearest = std::min(nearest, length(r.tree.position(p) - r.tree.position(q)));
        least = std::min(least, nearest);
        sum += nearest;
        ++count;
    }
    ASSERT_GT(count, 40u);
    const double spacing = 0.5 / n;  // of leaves a quarter as large
    EXPECT_GT(least, 0.4 * spacing);
    EXPECT_GT(sum / static_cast<double>(count), 0.7 * spacing);
}

TEST(Insertion, ChildrenOnASphereStayOnIt) {
    // Off it by the second order of the spacing, and less than the tangent plane is at .75 R.
    const auto farthest = [](std::size_t n) {
        Refined r(scene_of({shapes::sphere(n, 1.0, 1.0, 0.5, 0.0)}), 10 * n);
        r.refine([](const Vec3& p) { return p.z > 0.1 ? 1.0 : 0.0; }, 0.1, 2);
        EXPECT_GT(r.tree.leaves(), n);
        double most = 0.0;
        for (std::uint32_t p : r.leaves()) {
            most = std::max(most, std::abs(length(r.tree.position(p)) - 1.0));
            EXPECT_GT(dot(r.tree.normal(p), normalized(r.tree.position(p))), r.tree.is_inserted(p) ? 0.98 : 1 - 1e-9);
        }
        const double plane = 0.5 * std::pow(0.75 * r.scene.surfels.radii[0], 2.0);
        EXPECT_LT(most, 0.9 * plane) << n;
        return most;
    };
    EXPECT_GT(std::log(farthest(400) / farthest(6400)) / std::log(4.0), 1.6);
}

TEST(Insertion, NormalsOfChildrenTurnWithTheSurface) {
    // On a unit sphere a normal turns by as much as a place lies apart. Weighted means of normals around leave a good
    // part of that, to first order of the radius R, and more with each generation; slopes their stiffness, a hundredth
    // of what lies within reach of a disk, 2 R, and the second order.
    for (const std::size_t n : {400, 6400})
        for (const int rounds : {1, 3}) {
            Refined r(scene_of({shapes::sphere(n, 1.0, 1.0, 0.5, 0.0)}), 40 * n);
            r.refine([](const Vec3& p) { return p.z > 0.1 ? 1.0 : 0.0; }, 0.1, rounds);
            const double radius = r.scene.surfels.radii[0];
            std::size_t inserted = 0;
            for (std::uint32_t p : r.leaves()) {
                if (!r.tree.is_inserted(p)) continue;
                ++inserted;
                EXPECT_LT(length(cross(r.tree.normal(p), normalized(r.tree.position(p)))),
                          0.01 * 2.0 * radius + radius * radius)
                    << n << " " << rounds;
            }
            EXPECT_GT(inserted, 100u);
        }
}

TEST(Insertion, ChildrenOfAPatchLieInIt) {
    Refined r(grid_of_patches(10), 4000);
    EXPECT_EQ(r.refine(step, 0.1, 3), 3);
    for (std::uint32_t p : r.leaves()) {
        double own = 0.0;
        bool inside = false;
        for (const Triangle& t : r.tree.piece(p)) {
            own += area_of(t);
            const Vec3 n = cross_of(t), &at = r.tree.position(p);
            const double slack = -1e-12;
            inside =
                inside || (dot(cross(t.b - t.a, at - t.a), n) >= slack && dot(cross(t.c - t.b, at - t.b), n) >= slack &&
                           dot(cross(t.a - t.c, at - t.c), n) >= slack);
        }
        EXPECT_TRUE(inside) << p;
        EXPECT_NEAR(own, r.tree.area(p), 1e-14);
        EXPECT_EQ(r.tree.normal(p).z, 1.0);
    }
}

TEST(Insertion, TheMostIsNeverExceededAndUsedUp) {
    for (std::size_t room : {0u, 2u, 3u, 7u, 100u}) {
        Refined r(grid_of_points(16), 256 + room);
        const int rounds = r.refine(step, 0.1, 4);
        EXPECT_EQ(r.tree.leaves(), 256 + room / 3 * 3);
        EXPECT_EQ(rounds > 0, room >= 3);
        EXPECT_NEAR(r.leaf_area(), 1.0, 1e-12);
    }
}

TEST(Insertion, ThoseThatMatterMostGoFirst) {
    // Two steps, one ten times as high: with room for few all stand at the higher one.
    Refined r(grid_of_points(16), 256 + 30);
    r.refine([](const Vec3& p) { return (p.x > 0.25 ? 1.0 : 0.0) + (p.x > 0.75 ? 10.0 : 0.0); }, 0.1, 6);
    EXPECT_EQ(r.tree.leaves(), 286u);
    for (std::uint32_t p : r.leaves())
        if (r.tree.is_inserted(p)) {
            EXPECT_GT(r.tree.position(p).x, 0.6);
        }
}

TEST(Insertion, NoneIsSmallerThanItMayBe) {
    Refined r(grid_of_points(10), 100000, 0.125);
    EXPECT_LE(r.refine(step, 1e-6, 20), 3);
    double least = 1e300;
    for (std::uint32_t p : r.leaves()) least = std::min(least, r.tree.radius(p));
    EXPECT_EQ(least, 0.125 * r.scene.surfels.radii[0]);
}

TEST(Insertion, SmallestRadiusIsASixteenthByArea) {
    Surfels s = grid_of_points(4).surfels;
    EXPECT_NEAR(smallest_radius(s), 0.0625 * s.radii[0], 1e-15);
    s.areas[0] = 0.0;
    s.radii[0] = 100.0;  // what has no area has no say
    EXPECT_NEAR(smallest_radius(s), 0.0625 * s.radii[1], 1e-15);
}

TEST(Insertion, LeavesAllowed) {
    const Scene scene = grid_of_points(4);
    EXPECT_EQ(leaves_allowed(scene, false, 0), 16u);
    EXPECT_EQ(leaves_allowed(scene, false, 100), 16u);
    EXPECT_EQ(leaves_allowed(scene, true, 0), 32u);
    EXPECT_EQ(leaves_allowed(scene, true, 20), 20u);
}

TEST(Insertion, IsTheSameEveryTime) {
    Refined one(grid_of_points(12), 1000), other(grid_of_points(12), 1000);
    one.refine(step, 0.1, 3);
    other.refine(step, 0.1, 3);
    ASSERT_EQ(one.tree.points(), other.tree.points());
    for (std::uint32_t p = 0; p < one.tree.points(); ++p)
        EXPECT_EQ(length(one.tree.position(p) - other.tree.position(p)), 0.0);
}

}  // namespace
}  // namespace surflux
