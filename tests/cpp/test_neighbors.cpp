#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "refusal.h"
#include "shapes.h"
#include "surflux/core/error.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/neighbors/disk_index.h"
#include "surflux/neighbors/distinct_places.h"
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

TEST(DistinctPlaces, StandInTheOrderOfTheirFirstPoints) {
    const DistinctPlaces d = distinct_places({{1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0, 0, 0}, {1, 0, 0}});
    EXPECT_EQ(d.places, (std::vector<Vec3>{{1, 0, 0}, {0, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(d.of_point, (std::vector<std::uint32_t>{0, 1, 0, 2, 1, 0}));
    EXPECT_TRUE(distinct_places({}).places.empty());
}

TEST(DistinctPlaces, RefuseWhatCannotBeSorted) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(refusal([&] { distinct_places({{0, 0, 0}, {0, nan, 0}}); }),
              "points: wanted finite coordinates, got others at index 1");
}

TEST(PointIndex, AgreesWithBruteForce) {
    // The same far from the origin, and with one point far from the others.
    for (const Vec3& offset : {Vec3{}, Vec3{5e6, -5e6, 5e6}, Vec3{1e-3, 0.0, 0.0}}) {
        std::vector<Vec3> points = random_points(500, 1, offset);
        if (offset.x == 1e-3) points.push_back({1e12, -1e12, 1e12});
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
            std::vector<Neighbor> nearest_inside;
            index.nearest(points[q], 1000, nearest_inside, 0.25);
            EXPECT_EQ(nearest_inside.size(), found.size());
            const auto inside = std::count_if(all.begin(), all.end(), [](const auto& a) { return a.first <= 0.25; });
            EXPECT_EQ(static_cast<long>(found.size()), inside);
        }
    }
}

TEST(PointIndex, OfManyPointsAgreesWithBruteForceWhereDistancesAreEqual) {
    // A grid in random order, every point thrice: of all that are as far, the least numbers are nearest.
    std::vector<Vec3> points;
    for (int k = 0; k < 3 * 40 * 40 * 40; ++k) {
        const int at = k / 3;
        points.push_back({at % 40 * 0.25, at / 40 % 40 * 0.25, at / 1600 * 0.25});
    }
    Random random(5);
    for (std::size_t k = points.size(); k > 1; --k) std::swap(points[k - 1], points[random.below(k)]);
    const PointIndex index(points);
    std::vector<Neighbor> found;
    for (std::size_t q = 0; q < 20; ++q) {
        const Vec3& at = points[q * 9000];
        std::vector<std::pair<double, std::uint32_t>> all;
        for (std::uint32_t i = 0; i < points.size(); ++i)
            if (const double d = length(points[i] - at); d <= 0.75) all.emplace_back(d, i);
        std::sort(all.begin(), all.end());
        index.nearest(at, 24, found);  // some of those next to it, and of those across edges
        ASSERT_EQ(found.size(), 24u);
        for (std::size_t k = 0; k < found.size(); ++k) EXPECT_EQ(found[k].index, all[k].second) << q << ' ' << k;
        found.clear();
        index.within(at, 0.75, found);
        EXPECT_EQ(found.size(), all.size());
    }
}

TEST(PointIndex, IsCancelledWhileItIsBuilt) {
    const std::vector<Vec3> points = random_points(200000, 3);
    int reports = 0;
    EXPECT_THROW(PointIndex(points, [&](std::size_t, std::size_t) { return ++reports < 3; }), Cancelled);
    EXPECT_EQ(reports, 3);
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

// What a search past all of them takes grows with the cube of their number: this would not end.
TEST(Estimates, DoNotSeeAPileOfCopies) {
    std::vector<Vec3> points = shapes::sphere(2000, 1.0, 1.0, 0.5, 0.0).positions;
    const std::vector<Vec3> normals = estimate_normals(points, {});
    const std::vector<double> radii = estimate_radii(points);
    points.insert(points.end(), 20000, points[77]);
    const std::vector<Vec3> piled_normals = estimate_normals(points, {});
    const std::vector<double> piled_radii = estimate_radii(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(piled_normals[i], normals[i < 2000 ? i : 77]);
        EXPECT_EQ(piled_radii[i], radii[i < 2000 ? i : 77]);
    }
}

TEST(Estimates, DoNotSeeAnOutlier) {
    Surfels s = shapes::sphere(2000, 1.0, 1.0, 0.5, 0.0);
    const std::vector<double> radii = estimate_radii(s.positions);
    s.positions.push_back({1e7, 3e6, -2e6});
    const std::vector<Vec3> normals = estimate_normals(s.positions, {});
    const std::vector<double> with_outlier = estimate_radii(s.positions);
    for (std::size_t i = 0; i < 2000; ++i) {
        EXPECT_GT(dot(normals[i], s.normals[i]), std::cos(0.09));
        EXPECT_NEAR(with_outlier[i], radii[i], 1e-6 * radii[i]);
    }
    EXPECT_NEAR(length(normals[2000]), 1.0, 1e-12);
}

TEST(Normals, AreExactOnPlaneGridsHoweverTheyTilt) {
    // On a straight border two neighbours stand opposite each other: what is between them is decided by rounding.
    for (const double degrees : {0.0, 10.0, 30.0, 45.0, 73.0}) {
        const double c = std::cos(degrees * pi / 180.0), s = std::sin(degrees * pi / 180.0);
        std::vector<Vec3> points;
        for (int i = 0; i < 35; ++i)
            for (int k = 0; k < 35; ++k) points.push_back({1.0 * i, c * k, s * k});
        const std::vector<Vec3> normals = estimate_normals(points, {});
        for (const Vec3& n : normals) EXPECT_NEAR(std::abs(dot(n, {0.0, -s, c})), 1.0, 1e-12);
    }
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

TEST(Normals, OfALongLineAreThoseOfTheNearestSurface) {
    // A wire, 20 000 points in line, stands on a floor. Far up it, no neighbourhood worth looking at spans a plane.
    std::vector<Vec3> points;
    for (int x = -10; x <= 10; ++x)
        for (int y = -10; y <= 10; ++y) points.push_back({0.1 * x, 0.1 * y, 0.0});
    const std::size_t floor = points.size();
    for (int k = 1; k <= 20000; ++k) points.push_back({0.0, 0.0, 0.01 * k});
    NormalOptions options;
    options.viewpoint = Vec3{50.0, 0.0, 50.0};
    for (const auto& view : {std::optional<Vec3>{}, options.viewpoint}) {
        options.viewpoint = view;
        const std::vector<Vec3> normals = estimate_normals(points, options);
        for (const Vec3& n : normals) EXPECT_NEAR(length(n), 1.0, 1e-12);
        EXPECT_NEAR(std::abs(normals[0].z), 1.0, 1e-9);
        for (std::size_t i = floor + 1000; i < points.size(); ++i)
            EXPECT_NEAR(std::abs(dot(normals[i], normals[floor + 1000])), 1.0, 1e-9);
    }
}

TEST(Normals, OfALineAndOnePointFarOffAreThoseOfTheirPlane) {
    std::vector<Vec3> points;
    for (int k = 0; k < 2000; ++k) points.push_back({double(k), 0.0, 0.0});
    points.push_back({1000.0, 1e5, 0.0});
    NormalOptions options;
    options.viewpoint = Vec3{0.0, 0.0, 1e6};
    for (const Vec3& n : estimate_normals(points, options)) EXPECT_NEAR(n.z, 1.0, 1e-9);
}

TEST(Normals, RefuseALineAndTooFewPoints) {
    EXPECT_EQ(refusal([] { estimate_normals({{0, 0, 0}, {1, 0, 0}}, {}); }),
              "normals: wanted at least 3 points to estimate them from, got 2; give normals");
    const std::string line = "normals: the points lie on a line or coincide, so no surface can be fitted; give normals";
    EXPECT_EQ(refusal([] { estimate_normals({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}, {}); }), line);
    EXPECT_EQ(refusal([] { estimate_normals({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 1, 0}}, {}); }), line);
}

// Between those of the points that were kept.
double smallest_distance(const std::vector<Vec3>& points, const std::vector<std::uint32_t>& kept) {
    std::vector<Vec3> samples;
    for (std::uint32_t i : kept) samples.push_back(points[i]);
    const PointIndex index(samples);
    std::vector<Neighbor> near;
    double smallest = std::numeric_limits<double>::infinity();
    for (const Vec3& p : samples) {
        index.nearest(p, 2, near);
        smallest = std::min(smallest, near[1].distance);
    }
    return smallest;
}

TEST(SampleElimination, KeepsAnEvenSubset) {
    std::vector<Vec3> points = random_points(5000, 5);
    for (Vec3& p : points) p.z = 0.0;  // a unit square
    const std::vector<std::uint32_t> kept = eliminate_samples(points, 1000, 1.0, 7);
    ASSERT_EQ(kept.size(), 1000u);
    EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
    EXPECT_EQ(std::adjacent_find(kept.begin(), kept.end()), kept.end());
    const double smallest = smallest_distance(points, kept);
    // Yuksel 2015, sec. 4: the smallest distance of M of 5 M samples is about 0.7 of the most that is possible,
    // 2 r_max = sqrt(2 A / (sqrt 3 M)); for random points it would be 0.03 of it.
    const double r_max = std::sqrt(1.0 / (2.0 * std::sqrt(3.0) * 1000.0));
    EXPECT_GT(smallest, 0.5 * 2.0 * r_max);
    EXPECT_LE(smallest, 2.0 * r_max);
    EXPECT_EQ(kept, eliminate_samples(points, 1000, 1.0, 7));
}

// Yuksel 2015, algorithm 1, in all pairs and without a heap: again and again goes who is crowded most,
// by lot where two are crowded alike.
std::vector<std::uint32_t> eliminated_plainly(const std::vector<Vec3>& points, std::size_t count, double area,
                                              std::uint64_t seed) {
    const std::size_t n = points.size();
    const double r_max = std::sqrt(area / (2.0 * std::sqrt(3.0) * static_cast<double>(count)));
    const double share = static_cast<double>(count) / static_cast<double>(n);
    const double r_min = r_max * (1.0 - std::pow(share, 1.5)) * 0.65;
    const auto weight = [&](std::size_t i, std::size_t j) {
        const double d = std::max(length(points[i] - points[j]), 2.0 * r_min);
        const double w = 1.0 - d / (2.0 * r_max), w2 = w * w, w4 = w2 * w2;
        return i == j || w <= 0.0 ? 0.0 : std::floor(w4 * w4 * 0x1p40) / 0x1p40;  // their sums are exact
    };
    std::vector<double> crowding(n, 0.0);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) crowding[i] += weight(i, j);
    for (std::size_t left = n; left > count; --left) {
        std::size_t most = 0;
        for (std::size_t i = 1; i < n; ++i)
            if (std::pair(crowding[i], Random(seed, i).bits()) > std::pair(crowding[most], Random(seed, most).bits()))
                most = i;
        for (std::size_t j = 0; j < n; ++j) crowding[j] -= weight(most, j);
        crowding[most] = -1e300;
    }
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < n; ++i)
        if (crowding[i] > -1e299) kept.push_back(i);
    return kept;
}

TEST(SampleElimination, LeavesWhomThePlainAlgorithmLeaves) {
    std::vector<Vec3> points = random_points(1500, 9);
    EXPECT_EQ(eliminate_samples(points, 300, 4.0, 7), eliminated_plainly(points, 300, 4.0, 7));  // a ball of points
    for (Vec3& p : points) p = {p.x, p.y - 3e6, 0.1 * std::sin(9.0 * p.x)};
    EXPECT_EQ(eliminate_samples(points, 300, 1.1, 7), eliminated_plainly(points, 300, 1.1, 7));
}

// The floor around a scanner: its density falls with the square of the distance, from 0.1 to 100 m.
std::vector<Vec3> floor_scan(std::size_t n) {
    Random random(11);
    std::vector<Vec3> points(n);
    for (Vec3& p : points) {
        const double r = 0.1 * std::pow(1000.0, random.uniform()), phi = 2.0 * pi * random.uniform();
        p = {r * std::cos(phi), r * std::sin(phi), 0.0};
    }
    return points;
}

TEST(SampleElimination, EvensOutAScan) {
    const std::vector<Vec3> points = floor_scan(20000);
    const double area = pi * 1e4;
    const std::vector<std::uint32_t> kept = eliminate_samples(points, 1000, area, 3);
    ASSERT_EQ(kept.size(), 1000u);
    EXPECT_EQ(kept, eliminate_samples(points, 1000, area, 3));
    EXPECT_NE(kept, eliminate_samples(points, 1000, area, 4));
    const double smallest = smallest_distance(points, kept);
    const double r_max = std::sqrt(area / (2.0 * std::sqrt(3.0) * 1000.0));
    EXPECT_GT(smallest, 0.5 * 2.0 * r_max);
}

// Half a million spacings apart, and more.
TEST(SampleElimination, IsAsEvenOverPlacesThatLieFarApart) {
    for (const double apart : {1e3, 1e6, 1e9}) {
        std::vector<Vec3> points = random_points(10000, 5);
        for (std::size_t i = 0; i < points.size(); ++i) points[i].z = 0.0, points[i].x += i % 2 == 0 ? 0.0 : apart;
        std::size_t far = 0;
        for (const std::uint32_t i : eliminate_samples(points, 2000, 2.0, 7)) far += points[i].x > 10.0;
        EXPECT_NEAR(double(far), 1000.0, 30.0) << apart;
    }
}

// Seven of eight are to stay, most of which share a few cells of side r_max: all pairs of them are some 10^8.
TEST(SampleElimination, GivesTheExactCountWhereMostMustStay) {
    const std::vector<Vec3> points = floor_scan(10000);
    for (const std::size_t count : {8750u, 9999u, 10000u}) {
        const std::vector<std::uint32_t> kept = eliminate_samples(points, count, pi * 1e4, 3);
        EXPECT_EQ(kept.size(), count);
        EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
        EXPECT_EQ(std::adjacent_find(kept.begin(), kept.end()), kept.end());
    }
    const std::vector<Vec3> pile(5000, Vec3{1.0, 2.0, 3.0});
    EXPECT_EQ(eliminate_samples(pile, 3750, 1.0, 3).size(), 3750u);
}

TEST(SampleElimination, ReportsAndCanBeCancelledToTheEnd) {
    std::vector<Vec3> points = random_points(20000, 5);
    for (Vec3& p : points) p.z = 0.0;
    const std::size_t n = 20000, count = 10000;
    std::size_t last = 0, end = 0, total = 0, calls = 0;
    eliminate_samples(points, count, 1.0, 0, [&](std::size_t done, std::size_t all) {
        EXPECT_GE(done, end);
        EXPECT_LE(done, all);
        EXPECT_TRUE(total == 0 || all == total);
        if (done < all) last = done;
        end = done, total = all, ++calls;
        return true;
    });
    EXPECT_EQ(end, total);
    EXPECT_GT(last, total - 2 * 4096);
    EXPECT_LE(total, 2 * n - count);
    std::size_t seen = 0;
    const Progress stop_at_last = [&](std::size_t done, std::size_t) { return ++seen, done < last; };
    EXPECT_THROW(eliminate_samples(points, count, 1.0, 0, stop_at_last), Cancelled);
    EXPECT_GT(calls, 1u);
}

TEST(SampleElimination, RefusesWhatItCannotGive) {
    const std::vector<Vec3> points = random_points(10, 6);
    EXPECT_THROW(eliminate_samples(points, 11, 1.0, 0), ArgumentError);
    EXPECT_THROW(eliminate_samples(points, 0, 1.0, 0), ArgumentError);
    EXPECT_THROW(eliminate_samples(points, 5, 0.0, 0), ArgumentError);
    std::vector<Vec3> holed = points;
    holed[3].y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(refusal([&] { eliminate_samples(holed, 5, 1.0, 0); }),
              "points: wanted finite coordinates, got others at index 3");
}

TEST(SampleTriangles, SharesPointsByAreaAndStaysInside) {
    // Areas 1/2 and 3/2: a quarter of the points, to one, falls on the first.
    const std::vector<std::array<Vec3, 3>> triangles{{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}},
                                                     {Vec3{0, 0, 1}, Vec3{3, 0, 1}, Vec3{0, 1, 1}}};
    const TriangleSamples points(triangles, 1000, 0);
    EXPECT_EQ(points.area(), 2.0);
    long first = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const SurfacePoint p = points[i];
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
