#include <gtest/gtest.h>

#include <numeric>

#include "shapes.h"
#include "surflux/area/effective_area.h"
#include "surflux/core/error.h"
#include "surflux/core/parallel.h"

namespace surflux {
namespace {

double sum(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

TEST(EffectiveArea, OfALoneDiskIsTheDisk) {
    const Surfels s = shapes::disk({1, 2, 3}, normalized({1, 1, 1}), 0.3);
    AreaOptions options;
    // Pixel centres inside a circle: the count is off by O(resolution^-1.5) of the area.
    options.resolution = 512;
    EXPECT_NEAR(effective_areas(s, options)[0], pi * 0.09, 2e-4 * pi * 0.09);
}

TEST(EffectiveArea, CoincidentDisksShareOne) {
    Surfels s = shapes::disk({0, 0, 0}, {0, 0, 1}, 1.0);
    const double alone = effective_areas(s, {})[0];
    s = select(s, {0, 0, 0});
    for (double area : effective_areas(s, {})) EXPECT_NEAR(area, alone / 3.0, 1e-6);
}

TEST(EffectiveArea, DisksThatFaceApartDoNotShare) {
    Surfels s = shapes::disk({0, 0, 0}, {0, 0, 1}, 1.0);
    const double alone = effective_areas(s, {})[0];
    s = two_sided(s);
    for (double area : effective_areas(s, {})) EXPECT_DOUBLE_EQ(area, alone);
}

TEST(EffectiveArea, InsideAFlatGridIsTheCell) {
    // On a lattice every surfel's share is the same by symmetry, and the shares add up to the plane (D04 eq. 3 to 5).
    Surfels s;
    const int n = 9;
    for (int x = 0; x < n; ++x)
        for (int y = 0; y < n; ++y) {
            s.positions.push_back({0.1 * x, 0.1 * y, 0.0});
            s.normals.push_back({0, 0, 1});
        }
    shapes::finish(s, 0.5, 0.0);
    s.radii.assign(s.size(), 0.15);
    AreaOptions options;
    options.resolution = 256;
    EXPECT_NEAR(effective_areas(s, options)[n * n / 2], 0.01, 1e-5);
}

TEST(EffectiveArea, TiltedNeighbourStretchesTheShare) {
    // Two disks at the same place, tilted by theta: over disk 1, disk 2's weight is exp(-kappa |y_2|), |y_2| the
    // distance in its own plane, and its element 1 / cos theta larger (D04 eq. 7 to 9). Integrated here in polar
    // coordinates.
    const double theta = 0.5, kappa = 3.0;
    Surfels s = shapes::disk({0, 0, 0}, {0, 0, 1}, 1.0);
    s = select(s, {0, 0});
    s.normals[1] = {std::sin(theta), 0.0, std::cos(theta)};
    AreaOptions options;
    options.method = AreaMethod::paper;
    options.resolution = 512;
    const int steps = 2000;
    double expected = 0.0;
    for (int a = 0; a < steps; ++a)
        for (int b = 0; b < 400; ++b) {
            const double r = (a + 0.5) / steps, phi = 2.0 * pi * (b + 0.5) / 400;
            const double x = r * std::cos(phi), y = r * std::sin(phi);
            const double r2 = std::sqrt(x * x / (std::cos(theta) * std::cos(theta)) + y * y);
            const double w1 = std::exp(-kappa * r), w2 = r2 <= 1.0 ? std::exp(-kappa * r2) : 0.0;
            expected += w1 * (w1 + w2 / std::cos(theta)) / ((w1 + w2) * (w1 + w2)) * r / steps * 2.0 * pi / 400;
        }
    EXPECT_NEAR(effective_areas(s, options)[0], expected, 1e-3 * expected);
}

TEST(EffectiveArea, OfPatchesIsExactAndTheirDisksTakeNothing) {
    Surfels s = shapes::cube_inside(3, 0.5, 0.0);
    const std::size_t patches = s.size();
    EXPECT_NEAR(sum(effective_areas(s, {})), 6.0, 1e-12);
    const Surfels lone = shapes::disk({0.5, 0.5, 0.01}, {0, 0, 1}, 0.1);  // close over a patch
    s.areas.clear();
    Scene scene;
    append(scene, s);
    Surfels without_areas = lone;
    without_areas.areas.clear();
    append(scene, without_areas);
    EXPECT_DOUBLE_EQ(effective_areas(scene.surfels, {})[patches], effective_areas(lone, {})[0]);
}

TEST(EffectiveArea, IsTheSameForAnyNumberOfThreads) {
    const Surfels s = shapes::sphere(500, 1.0, 1.0, 0.5, 0.0);
    const std::vector<double> all = effective_areas(s, {});
    const ThreadLimit one(1);
    EXPECT_EQ(effective_areas(s, {}), all);
}

TEST(EffectiveArea, ScalesAndRotatesWithTheCloud) {
    const Surfels s = shapes::sphere(300, 1.0, 1.0, 0.5, 0.0);
    const double before = sum(s.areas);
    for (double scale : {1e-6, 1e6}) {
        Surfels t = s;
        for (Vec3& p : t.positions) p *= scale;
        for (double& r : t.radii) r *= scale;
        EXPECT_NEAR(sum(effective_areas(t, {})) / (scale * scale), before, 1e-4 * before);
    }
    Surfels t = s;
    for (Vec3& p : t.positions) p += Vec3{5e6, 5e6, 5e6};
    EXPECT_NEAR(sum(effective_areas(t, {})), before, 1e-4 * before);
}

TEST(EffectiveArea, OfASphereIsRightToSecondOrder) {
    // The paper's areas are off by O((R / r)^2), a quarter of that at half the spacing; curved ones are off by less
    // than 0.1 % at either.
    for (std::size_t n : {160u, 640u}) {
        const Surfels s = shapes::sphere(n, 1.0, 1.0, 0.5, 0.0);
        EXPECT_NEAR(sum(effective_areas(s, {})) / (4.0 * pi), 1.0, n == 160u ? 3e-3 : 1e-3);
        AreaOptions paper;
        paper.method = AreaMethod::paper;
        EXPECT_GT(sum(effective_areas(s, paper)) / (4.0 * pi), n == 160u ? 1.06 : 1.015);
    }
}

TEST(EffectiveArea, GoesToTheNearestHoweverTheRadiiVary) {
    // A square lattice with radii of 0.15 and 0.3 by turns: each still has its cell, but for the taper towards its own
    // rim, some 6 %. By distance over R_j the larger ones would have almost all.
    Surfels s;
    for (int x = 0; x < 11; ++x)
        for (int y = 0; y < 11; ++y) {
            s.positions.push_back({0.1 * x, 0.1 * y, 0.0});
            s.normals.push_back({0, 0, 1});
            s.radii.push_back((x + y) % 2 == 0 ? 0.15 : 0.3);
        }
    shapes::finish(s, 0.5, 0.0);
    const std::vector<double> areas = effective_areas(s, {});
    for (int k : {60, 61, 71, 72}) EXPECT_NEAR(areas[static_cast<std::size_t>(k)], 0.01, 1e-3);
}

TEST(EffectiveArea, DisksDoNotCountTwiceWhatTheyOverhang) {
    // Two sheets of a lattice that meet at a right angle, the first row of each half a cell off the edge. Alone, each
    // row along the edge also has what its disks overhang; beside the other sheet's rows, shares of it go there.
    const auto sheet = [](bool upright) {
        Surfels s;
        for (int x = 0; x < 11; ++x)
            for (int y = 0; y < 11; ++y) {
                const double d = 0.1 * x + 0.05;
                s.positions.push_back(upright ? Vec3{0.0, 0.1 * y, -d} : Vec3{d, 0.1 * y, 0.0});
                s.normals.push_back(upright ? Vec3{-1, 0, 0} : Vec3{0, 0, 1});
            }
        s.radii.assign(s.positions.size(), 0.15);
        shapes::finish(s, 0.5, 0.0);
        return s;
    };
    Scene scene;
    append(scene, sheet(false));
    const double alone = effective_areas(scene.surfels, {})[5];
    append(scene, sheet(true));
    const double creased = effective_areas(scene.surfels, {})[5];
    EXPECT_GT(alone, 0.013);
    EXPECT_NEAR(creased, 0.01, 1e-3);
}

TEST(EffectiveArea, StaysFiniteForAnyKappaAllowed) {
    const Surfels s = shapes::sphere(200, 1.0, 1.0, 0.5, 0.0);
    for (const auto& [method, kappa] : {std::pair(AreaMethod::paper, 80.0), std::pair(AreaMethod::curved, 8.0),
                                        std::pair(AreaMethod::curved, 2.5), std::pair(AreaMethod::curved, 0.1)})
        EXPECT_NEAR(sum(effective_areas(s, {method, kappa, 32, 0.8})) / (4.0 * pi), 1.0, 0.1) << kappa;
}

TEST(EffectiveArea, RefusesOptionsOutOfRange) {
    const Surfels s = shapes::disk({0, 0, 0}, {0, 0, 1}, 1.0);
    EXPECT_THROW(effective_areas(s, {AreaMethod::paper, 0.0, 32, 0.8}), ArgumentError);
    EXPECT_THROW(effective_areas(s, {AreaMethod::curved, 9.0, 32, 0.8}), ArgumentError);
    EXPECT_THROW(effective_areas(s, {AreaMethod::paper, 3.0, 3, 0.8}), ArgumentError);
    EXPECT_THROW(effective_areas(s, {AreaMethod::paper, 3.0, 32, 1.0}), ArgumentError);
}

}  // namespace
}  // namespace surflux
