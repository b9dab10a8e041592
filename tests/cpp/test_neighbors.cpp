#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "shapes.h"
#include "surflux/core/error.h"
#include "surflux/core/random.h"
#include "surflux/neighbors/disk_index.h"
#include "surflux/neighbors/normals.h"
#include "surflux/neighbors/point_index.h"
#include "surflux/neighbors/radii.h"
#include "surflux/neighbors/sample_elimination.h"
#include "surflux/scene/sample_triangles.h"

namespace surflux {
namespace {

std::vector<Vec3> random_points(std::size_t n, std::uint64_t seed, const Vec3& offset = {}) {
    Random random(seed);
    std::vector<Vec3> points(n);
    for (Vec3& p : points) p = offset + Vec3{random.uniform(), random.uniform(), random.uniform()};
    return points;
}

TEST(PointIndex, AgreesWithBruteForce) {
    // The same far from the origin: coordinates are recentred before they become floats.
    for (const Vec3& offset : {Vec3{}, Vec3{5e6, -5e6, 5e6}}) {
        const std::vector<Vec3> points = random_points(500, 1, offset);
        const PointIndex index(points);
        std::vector<Neighbor> found;
        for (std::size_t q = 0; q < 50; ++q) {
            std::vector<std::pair<double, std::uint32_t>> all;
            for (std::uint32_t i = 0; i < points.size(); ++i) all.emplace_back(length(points[i] - points[q]), i);
            std::sort(all.begin(), all.end());
            index.nearest(points[q], 9, found);
            ASSERT_EQ(found.size(), 9u);
            for (std::size_t k = 0; k < 9; ++k) {
                EXPECT_EQ(found[k].index, all[k].second);
                EXPECT_NEAR(found[k].distance, all[k].first, 1e-6);
            }
            found.clear();
            index.within(points[q], 0.25, found);
            const auto inside = std::count_if(all.begin(), all.end(), [](const auto& a) { return a.first <= 0.25; });
            EXPECT_EQ(static_cast<long>(found.size()), inside);
        }
    }
}

TEST(PointIndex, GivesAllPointsWhenAskedForMore) {
    const PointIndex index(random_points(5, 2));
    std::vector<Neighbor> found;
    index.nearest({0.5, 0.5, 0.5}, 100, found);
    EXPECT_EQ(found.size(), 5u);
}

TEST(DiskIndex, AgreesWithBruteForceOverFourDecadesOfRadii) {
    const std::vector<Vec3> centers = random_points(400, 3);
    Random random(4);
    std::vector<double> radii(centers.size());
    for (double& r : radii) r = std::pow(10.0, -4.0 + 3.5 * random.uniform());
    const DiskIndex index(centers, radii);
    std::vector<Neighbor> found;
    for (std::size_t q = 0; q < centers.size(); ++q) {
        found.clear();
        index.reaching(centers[q], radii[q], found);
        std::set<std::uint32_t> got, wanted;
        for (const Neighbor& n : found) got.insert(n.index);
        for (std::uint32_t i = 0; i < centers.size(); ++i)
            if (length(centers[i] - centers[q]) < radii[q] + radii[i]) wanted.insert(i);
        EXPECT_EQ(got, wanted);
        EXPECT_EQ(got.size(), found.size());
    }
}

TEST(Radii, AreTheDistanceToTheSixthNeighbourOnASquareGrid) {
    // Inside a unit grid four neighbours are at 1 and four at sqrt 2: the sixth is at sqrt 2.
    std::vector<Vec3> grid;
    for (int x = 0; x < 7; ++x)
        for (int y = 0; y < 7; ++y) grid.push_back({double(x), double(y), 0.0});
    const std::vector<double> radii = estimate_radii(grid, 6);
    EXPECT_NEAR(radii[3 * 7 + 3], std::sqrt(2.0), 1e-6);
    // A duplicate is at the same place: it is nobody's further neighbour.
    std::vector<Vec3> twice = grid;
    twice.insert(twice.end(), grid.begin(), grid.end());
    const std::vector<double> doubled = estimate_radii(twice, 6);
    for (std::size_t i = 0; i < grid.size(); ++i) EXPECT_DOUBLE_EQ(doubled[i], radii[i]);
}

TEST(Radii, LeaveNoGapsBetweenRandomPointsOnASphere) {
    // Not spread evenly at all: the sixth neighbour alone leaves 1e-3 of such a sphere uncovered.
    Random random(8);
    const auto on_sphere = [&random] {
        const double z = 2.0 * random.uniform() - 1.0, phi = 2.0 * pi * random.uniform(), r = std::sqrt(1.0 - z * z);
        return Vec3{r * std::cos(phi), r * std::sin(phi), z};
    };
    std::vector<Vec3> points(2000);
    for (Vec3& p : points) p = on_sphere();
    const DiskIndex disks(points, estimate_radii(points));
    std::vector<Neighbor> over;
    int uncovered = 0;
    for (int k = 0; k < 100000; ++k) {
        over.clear();
        disks.reaching(on_sphere(), 0.0, over);
        uncovered += over.empty();
    }
    EXPECT_LE(uncovered, 10);  // of 100 000
}

TEST(Radii, OfAnOutlierFollowThoseOfItsNeighbours) {
    std::vector<Vec3> points;
    for (int x = 0; x < 7; ++x)
        for (int y = 0; y < 7; ++y) points.push_back({double(x), double(y), 0.0});
    points.push_back({3.0, 3.0, 50.0});
    const std::vector<double> radii = estimate_radii(points, 6);
    EXPECT_NEAR(radii[3 * 7 + 3], std::sqrt(2.0), 1e-6);
    EXPECT_NEAR(radii[49], 2.0 * std::sqrt(2.0), 1e-6);  // not 50: its neighbours lie in the middle of the grid
}

TEST(Radii, RefuseWhatHasNoNeighbours) {
    EXPECT_THROW(estimate_radii({{0, 0, 0}}), ArgumentError);
    EXPECT_THROW(estimate_radii({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}), ArgumentError);
}

TEST(Normals, PointOutOfASphereAndTowardsAViewpoint) {
    const Surfels s = shapes::sphere(2000, 1.0, 1.0, 0.5, 0.0, {7, 8, 9});
    const std::vector<Vec3> normals = estimate_normals(s.positions, {});
    // A plane fit over the cap of 16 points leans by far less than the cap's own half angle, about 0.09 rad.
    for (std::size_t i = 0; i < s.size(); ++i) EXPECT_GT(dot(normals[i], s.normals[i]), std::cos(0.09));
    NormalOptions options;
    options.viewpoint = Vec3{7, 8, 9};  // a scanner inside
    const std::vector<Vec3> inward = estimate_normals(s.positions, options);
    for (std::size_t i = 0; i < s.size(); ++i) EXPECT_LT(dot(inward[i], s.normals[i]), -std::cos(0.09));
}

TEST(Normals, OrientSeparateComponentsEachOutwards) {
    Surfels a = shapes::sphere(500, 1.0, 1.0, 0.5, 0.0);
    const Surfels b = shapes::sphere(500, 0.5, 1.0, 0.5, 0.0, {10, 0, 0});
    a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
    a.normals.insert(a.normals.end(), b.normals.begin(), b.normals.end());
    const std::vector<Vec3> normals = estimate_normals(a.positions, {});
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_GT(dot(normals[i], a.normals[i]), 0.9);
}

TEST(Normals, RefuseALineAndTooFewPoints) {
    EXPECT_THROW(estimate_normals({{0, 0, 0}, {1, 0, 0}}, {}), ArgumentError);
    EXPECT_THROW(estimate_normals({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}, {}), ArgumentError);
}

TEST(SampleElimination, KeepsAnEvenSubset) {
    std::vector<Vec3> points = random_points(5000, 5);
    for (Vec3& p : points) p.z = 0.0;  // a unit square
    const std::vector<std::uint32_t> kept = eliminate_samples(points, 1000, 1.0, 7);
    ASSERT_EQ(kept.size(), 1000u);
    EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
    EXPECT_EQ(std::adjacent_find(kept.begin(), kept.end()), kept.end());
    std::vector<Vec3> samples;
    for (std::uint32_t i : kept) samples.push_back(points[i]);
    const PointIndex index(samples);
    std::vector<Neighbor> near;
    double smallest = 1.0;
    for (const Vec3& p : samples) {
        index.nearest(p, 2, near);
        smallest = std::min(smallest, near[1].distance);
    }
    // Yuksel 2015, sec. 4: the smallest distance of M of 5 M samples is about 0.7 of the most that is possible,
    // 2 r_max = sqrt(2 A / (sqrt 3 M)); for random points it would be 0.03 of it.
    const double r_max = std::sqrt(1.0 / (2.0 * std::sqrt(3.0) * 1000.0));
    EXPECT_GT(smallest, 0.5 * 2.0 * r_max);
    EXPECT_LE(smallest, 2.0 * r_max);
    EXPECT_EQ(kept, eliminate_samples(points, 1000, 1.0, 7));
}

TEST(SampleElimination, RefusesWhatItCannotGive) {
    const std::vector<Vec3> points = random_points(10, 6);
    EXPECT_THROW(eliminate_samples(points, 11, 1.0, 0), ArgumentError);
    EXPECT_THROW(eliminate_samples(points, 0, 1.0, 0), ArgumentError);
    EXPECT_THROW(eliminate_samples(points, 5, 0.0, 0), ArgumentError);
}

TEST(SampleTriangles, SharesPointsByAreaAndStaysInside) {
    // Areas 1/2 and 3/2: a quarter of the points, to one, falls on the first.
    const std::vector<std::array<Vec3, 3>> triangles{{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}},
                                                     {Vec3{0, 0, 1}, Vec3{3, 0, 1}, Vec3{0, 1, 1}}};
    const std::vector<SurfacePoint> points = sample_triangles(triangles, 1000, 0);
    long first = 0;
    for (const SurfacePoint& p : points) {
        const double x = p.triangle == 0 ? p.position.x : p.position.x / 3.0;
        EXPECT_GE(x, -1e-12);
        EXPECT_GE(p.position.y, -1e-12);
        EXPECT_LE(x + p.position.y, 1.0 + 1e-12);
        EXPECT_NEAR(p.position.z, double(p.triangle), 1e-12);
        first += p.triangle == 0;
    }
    EXPECT_NEAR(double(first), 250.0, 1.0);
}

}  // namespace
}  // namespace surflux
