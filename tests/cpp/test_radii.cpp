#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "refusal.h"
#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/neighbors/disk_index.h"
#include "surflux/neighbors/radii.h"
#include "surflux/neighbors/tangent_cell.h"

namespace surflux {
namespace {

constexpr double margin = 1.1;

using Sampler = std::function<Vec3(Random&)>;

Vec3 on_sphere(Random& random) {
    const double z = 2.0 * random.uniform() - 1.0, phi = 2.0 * pi * random.uniform(), r = std::sqrt(1.0 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
}

// Uniform on the torus of radii 1 and 0.4.
Vec3 on_torus(Random& random) {
    for (;;) {
        const double u = 2.0 * pi * random.uniform(), v = 2.0 * pi * random.uniform(), r = 1.0 + 0.4 * std::cos(v);
        if (1.4 * random.uniform() < r) return {r * std::cos(u), r * std::sin(u), 0.4 * std::sin(v)};
    }
}

Vec3 on_square(Random& random) { return {random.uniform(), random.uniform(), 0.0}; }

std::vector<Vec3> samples(std::size_t n, const Sampler& sampler, std::uint64_t seed) {
    Random random(seed);
    std::vector<Vec3> points(n);
    for (Vec3& p : points) p = sampler(random);
    return points;
}

std::vector<Vec3> fibonacci_sphere(std::size_t n) {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < n; ++i) {
        const double z = 1.0 - 2.0 * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
        const double phi = pi * (1.0 + std::sqrt(5.0)) * static_cast<double>(i), r = std::sqrt(1.0 - z * z);
        points.push_back({r * std::cos(phi), r * std::sin(phi), z});
    }
    return points;
}

std::vector<Vec3> grid(int n) {
    std::vector<Vec3> points;
    for (int x = 0; x < n; ++x)
        for (int y = 0; y < n; ++y) points.push_back({double(x), double(y), 0.0});
    return points;
}

// Of 50 000 points on the surface, those that no disk reaches, and the area of the disks over that of the surface.
struct Cover {
    int uncovered = 0;
    double overlap = 0.0;
};

Cover cover(const std::vector<Vec3>& points, const std::vector<double>& radii, const Sampler& sampler, double area) {
    const DiskIndex disks(points, radii);
    Cover out;
    std::vector<Neighbor> over;
    for (const Vec3& probe : samples(50000, sampler, 77)) {
        over.clear();
        disks.reaching(probe, 0.0, over);
        out.uncovered += over.empty();
    }
    for (double r : radii) out.overlap += pi * r * r / area;
    return out;
}

// Around the origin, in the plane z = 0.
double covering_radius(const std::vector<Vec3>& neighbors, double border = 1e9) {
    TangentCell cell;
    cell.start({}, {0, 0, 1}, 100.0);
    for (const Vec3& n : neighbors) cell.cut(n);
    return cell.covering_radius(border);
}

TEST(TangentCell, ReachesTheCornersOfAcuteTriangles) {
    const double h = std::sqrt(0.75);
    const std::vector<Vec3> hexagon{{1, 0, 0}, {-1, 0, 0}, {0.5, h, 0}, {-0.5, h, 0}, {0.5, -h, 0}, {-0.5, -h, 0}};
    EXPECT_NEAR(covering_radius(hexagon), 1.0 / std::sqrt(3.0), 1e-12);
    EXPECT_NEAR(covering_radius({{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}), std::sqrt(0.5), 1e-12);
}

TEST(TangentCell, NeedsNotReachTheCornersOfObtuseOnes) {
    // 150 degrees between neighbours at 1: their bisectors meet at 1.93, but leave the triangle at 0.518.
    const double x = std::cos(pi * 75 / 180), y = std::sin(pi * 75 / 180);
    EXPECT_NEAR(covering_radius({{x, y, 0}, {x, -y, 0}}), 0.5 / std::cos(pi * 15 / 180), 1e-12);
    // The same triangle, twice, from a sharp end: there too the part that is nearest ends in the long side.
    EXPECT_NEAR(covering_radius({{-x, y, 0}, {0, 2 * y, 0}, {x, y, 0}}), 0.5 / std::cos(pi * 15 / 180), 1e-12);
}

TEST(TangentCell, IsOpenWithoutNeighboursAllAround) {
    EXPECT_EQ(covering_radius({}), 0.0);
    EXPECT_NEAR(covering_radius({{1, 0, 0}, {-2, 0, 0}}), 1.0, 1e-12);  // strip: half way to either
    EXPECT_EQ(covering_radius({{0, 0, 1}}), 0.0);                       // straight above
}

TEST(TangentCell, IsHardlyCutFromAnotherSheet) {
    // Between a point of the plane and one 1 above it, 0.5 aside, the plane is halved 1.25 away.
    EXPECT_NEAR(covering_radius({{0.5, 0, 1}}), 1.25, 1e-12);
}

TEST(TangentCell, EndsAtABorder) {
    // Two near neighbours, and a pair of another piece, whose corners are 3 away.
    const std::vector<Vec3> piece{{1, 0, 0}, {0, 1, 0}, {-6, 0, 0}, {0, -6, 0}};
    EXPECT_GT(covering_radius(piece), 3.0);
    EXPECT_NEAR(covering_radius(piece, 2.0), std::sqrt(0.5), 1e-12);
}

TEST(TangentCell, IsOpenWhereTheSurfaceEnds) {
    TangentCell cell;
    cell.start({}, {0, 0, 1}, 100.0);
    for (const Vec3& n : {Vec3{1, 0, 0}, Vec3{0, 1, 0}}) cell.cut(n);
    for (const Vec3& n : {Vec3{-4, 0, 0}, Vec3{0, -4, 0}}) cell.cut_open(n);
    EXPECT_NEAR(cell.farthest(), 2.0 * std::sqrt(2.0), 1e-12);
    EXPECT_NEAR(cell.covering_radius(1e9), std::sqrt(0.5), 1e-12);
}

TEST(Radii, OfASquareGridReachTheMiddlesOfItsCells) {
    const std::vector<Vec3> points = grid(7);
    const std::vector<double> radii = estimate_radii(points);
    // On the border too: inwards there are corners all the same.
    for (double r : radii) EXPECT_NEAR(r, margin * std::sqrt(0.5), 1e-9);
    // A duplicate is at the same place: it is nobody's further neighbour.
    std::vector<Vec3> twice = points;
    twice.insert(twice.end(), points.begin(), points.end());
    const std::vector<double> doubled = estimate_radii(twice);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_DOUBLE_EQ(doubled[i], radii[i]);
        EXPECT_DOUBLE_EQ(doubled[points.size() + i], radii[i]);
    }
}

TEST(Radii, LeaveNoGapsAndLittleOverlap) {
    struct Case {
        const char* name;
        std::vector<Vec3> points;
        Sampler surface;
        double area, overlap;
    };
    // At least 1.21 (a hexagonal lattice) times the margin squared.
    const Case cases[] = {
        {"642 Fibonacci", fibonacci_sphere(642), on_sphere, 4 * pi, 1.85},
        {"10 000 Fibonacci", fibonacci_sphere(10000), on_sphere, 4 * pi, 1.8},
        {"2000 random", samples(2000, on_sphere, 8), on_sphere, 4 * pi, 3.6},
        {"35 000 random", samples(35000, on_sphere, 8), on_sphere, 4 * pi, 3.6},
        {"torus", samples(3000, on_torus, 8), on_torus, 1.6 * pi * pi, 3.7},
        {"square", samples(1000, on_square, 8), on_square, 1.0, 4.0},
    };
    for (const Case& c : cases) {
        const Cover got = cover(c.points, estimate_radii(c.points), c.surface, c.area);
        EXPECT_LE(got.uncovered, 10) << c.name;  // 99.98 %
        EXPECT_LE(got.overlap, c.overlap) << c.name;
    }
}

TEST(Radii, WithoutMarginLeaveNoGapsEither) {
    const std::vector<Vec3> points = samples(3000, on_torus, 9);
    std::vector<double> radii = estimate_radii(points);
    for (double& r : radii) r /= margin;
    EXPECT_LE(cover(points, radii, on_torus, 1.6 * pi * pi).uncovered, 10);
    for (double& r : radii) r *= 0.8;  // this test can tell
    EXPECT_GE(cover(points, radii, on_torus, 1.6 * pi * pi).uncovered, 1000);
}

TEST(Radii, FollowTheDensity) {
    // Density falls by 20 from pole to pole.
    const Sampler uneven = [](Random& random) {
        for (;;) {
            const Vec3 p = on_sphere(random);
            if (random.uniform() < std::pow(20.0, -0.5 * (1.0 + p.z))) return p;
        }
    };
    const std::vector<Vec3> points = samples(5000, uneven, 5);
    const Cover got = cover(points, estimate_radii(points, points), on_sphere, 4 * pi);
    EXPECT_LE(got.uncovered, 25);
    EXPECT_LE(got.overlap, 3.7);
}

TEST(Radii, KeepTheSheetsOfAThinPlateApart) {
    // Two sheets a fifth of the spacing apart, facing out: with normals each covers itself as if it were alone.
    const std::vector<Vec3> lower = grid(12);
    std::vector<Vec3> points = lower, normals(lower.size(), {0, 0, -1});
    for (const Vec3& p : lower) {
        points.push_back(p + Vec3{0.4, 0.3, 0.2});
        normals.push_back({0, 0, 1});
    }
    for (double r : estimate_radii(points, normals)) EXPECT_NEAR(r, margin * std::sqrt(0.5), 1e-9);
    // Two-sided sheets stored as pairs: every place faces both ways.
    std::vector<Vec3> pairs = lower, both(lower.size(), {0, 0, -1});
    pairs.insert(pairs.end(), lower.begin(), lower.end());
    both.insert(both.end(), lower.size(), {0, 0, 1});
    for (double r : estimate_radii(pairs, both)) EXPECT_NEAR(r, margin * std::sqrt(0.5), 1e-9);
    // A point that alone faces the other way has all its neighbours still.
    std::vector<Vec3> flipped(lower.size(), {0, 0, 1});
    flipped[5 * 12 + 5] = {0, 0, -1};
    EXPECT_NEAR(estimate_radii(lower, flipped)[5 * 12 + 5], margin * std::sqrt(0.5), 1e-9);
}

TEST(Radii, OnALineReachHalfWay) {
    std::vector<Vec3> line;
    for (int k = 0; k < 30; ++k) line.push_back({0.3 * k, 0.4 * k, 0.0});
    for (double r : estimate_radii(line)) EXPECT_NEAR(r, margin * 0.25, 1e-9);
    // Seen along the line, all are straight above and below.
    for (double r : estimate_radii(line, std::vector<Vec3>(30, {0.6, 0.8, 0.0}))) EXPECT_NEAR(r, margin * 0.25, 1e-9);
}

// Points of `lines` lines, `apart` steps of 1 from each other, a little off them.
std::vector<Vec3> scan_lines(int lines, double apart, double off) {
    Random random(3);
    std::vector<Vec3> out;
    for (int line = 0; line < lines; ++line)
        for (int k = 0; k < 12 * apart; ++k)
            out.push_back({k + off * (2 * random.uniform() - 1), apart * line + off * (2 * random.uniform() - 1), 0});
    return out;
}

// At 1:40 disks stayed within their line, and a scanned roof let all light through.
TEST(Radii, ReachHalfWayFromLineToLine) {
    for (double apart : {8.0, 10.0, 11.0, 20.0, 40.0, 90.0})
        for (double off : {0.0, 0.2}) {
            const std::vector<Vec3> points = scan_lines(12, apart, off);
            const std::vector<double> radii = estimate_radii(points, std::vector<Vec3>(points.size(), {0, 0, 1}));
            const DiskIndex disks(points, radii);
            std::vector<Neighbor> over;
            Random random(5);
            int uncovered = 0;
            for (int k = 0; k < 5000; ++k) {  // away from the ends, and between lines that have others beside them
                const Vec3 probe{apart * (1 + 10 * random.uniform()), apart * (1 + 9 * random.uniform()), 0};
                over.clear();
                disks.reaching(probe, 0.0, over);
                uncovered += over.empty();
            }
            EXPECT_LE(uncovered, 50) << apart << " apart, off by " << off;
            EXPECT_LE(*std::max_element(radii.begin(), radii.end()), 0.75 * margin * apart);
        }
}

// Disks of tiles of 16 points reached half way to the next tile: 12 times their area.
TEST(Radii, OfSmallPiecesStayOnThem) {
    for (int side : {4, 5, 6})
        for (double gap : {14.0, 16.0, 40.0}) {
            Random random(1);
            std::vector<Vec3> points;
            for (int k = 0; k < 25 * side * side; ++k) {
                const int piece = k / (side * side), place = k % (side * side);
                const double tile = side + gap;
                points.push_back({tile * (piece % 5) + place % side + 0.1 * random.uniform(),
                                  tile * (piece / 5) + place / side + 0.1 * random.uniform(), 0});
            }
            const std::vector<double> radii = estimate_radii(points, std::vector<Vec3>(points.size(), {0, 0, 1}));
            EXPECT_LE(*std::max_element(radii.begin(), radii.end()), 2.0) << side << " each way, " << gap << " apart";
        }
}

// Disks of small roofs over a ground of the same density reached over all of the street, 15 wide, up to 15.
TEST(Radii, OfRoofsEndAboveTheStreet) {
    const auto on_roof = [](const Vec3& p) { return std::fmod(p.x, 25.0) > 15.0 && std::fmod(p.y, 25.0) > 15.0; };
    for (std::uint64_t seed : {1, 2, 3})
        for (std::size_t n : {2500, 3000, 4000}) {  // 25 to 40 points a roof
            std::vector<Vec3> points = samples(n, [](Random& r) { return 100.0 * on_square(r); }, seed);
            for (Vec3& p : points) p.z = on_roof(p) ? 10.0 : 0.0;
            const std::vector<double> radii = estimate_radii(points, std::vector<Vec3>(n, {0, 0, 1}));
            const double spacing = 100.0 / std::sqrt(static_cast<double>(n));
            double overhang = 0.0;
            std::vector<Vec3> roofs;
            std::vector<double> theirs;
            for (std::size_t i = 0; i < n; ++i) {
                const Vec3& p = points[i];
                if (!on_roof(p)) continue;
                const double to_edge =
                    5.0 - std::max(std::abs(std::fmod(p.x, 25.0) - 20.0), std::abs(std::fmod(p.y, 25.0) - 20.0));
                overhang += std::max(0.0, radii[i] - to_edge);
                roofs.push_back(p);
                theirs.push_back(radii[i]);
            }
            EXPECT_LE(*std::max_element(theirs.begin(), theirs.end()), 7.5) << n << " points, seed " << seed;
            EXPECT_LE(overhang / static_cast<double>(roofs.size()), 0.45 * spacing) << n << " points, seed " << seed;
            const Sampler inside = [](Random& r) {
                const Vec3 p = on_square(r), q = on_square(r);
                return Vec3{25.0 * std::floor(4.0 * q.x) + 17.0 + 6.0 * p.x,
                            25.0 * std::floor(4.0 * q.y) + 17.0 + 6.0 * p.y, 10.0};
            };
            EXPECT_LE(cover(roofs, theirs, inside, 1600.0).uncovered, 500) << n << " points, seed " << seed;  // 1 %
        }
}

TEST(Radii, OfAnOutlierFollowThoseOfItsNeighbours) {
    std::vector<Vec3> points = grid(7);
    points.push_back({3.0, 3.0, 50.0});
    const std::vector<double> radii = estimate_radii(points);
    EXPECT_NEAR(radii[3 * 7 + 3], margin * std::sqrt(0.5), 1e-6);
    EXPECT_NEAR(radii[49], 2.5 * margin * std::sqrt(0.5), 1e-6);  // not 25, half way
}

TEST(Radii, OfTwoPlacesReachHalfWay) {
    for (double r : estimate_radii({{1, 0, 0}, {3, 0, 0}, {1, 0, 0}})) EXPECT_NEAR(r, margin, 1e-12);
}

TEST(Radii, AreTheSameForAnyNumberOfThreads) {
    const std::vector<Vec3> points = samples(5000, on_torus, 3);
    const std::vector<double> many = estimate_radii(points);
    const ThreadLimit one(1);
    EXPECT_EQ(estimate_radii(points), many);
}

// The pole of a globe made by sines: many places that differ by rounding alone, which a search from afar cannot tell
// apart.
TEST(Radii, AreThereWhereManyPlacesDifferByRoundingAlone) {
    std::vector<Vec3> points;
    for (int ball = 0; ball < 3; ++ball)
        for (int i = 0; i <= 16; ++i)
            for (int j = 0; j < 64; ++j) {
                const double theta = pi * i / 16, phi = 2.0 * pi * j / 64, r = std::sin(theta);
                const double along = 3.0 * ball;
                points.push_back({r * std::cos(phi) + along, r * std::sin(phi) + along, std::cos(theta)});
            }
    for (double radius : estimate_radii(points)) EXPECT_TRUE(radius > 0.0 && radius < 0.5) << radius;
}

TEST(Radii, RefuseWhatHasNoNeighbours) {
    EXPECT_EQ(refusal([] { estimate_radii({{0, 0, 0}}); }),
              "radii: wanted at least 2 points to estimate them from, got 1; give radii");
    EXPECT_EQ(refusal([] { estimate_radii({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}); }),
              "radii: all points coincide; give radii");
    EXPECT_EQ(refusal([] { estimate_radii({{1, 1, 1}, {2, 1, 1}}, {{0, 0, 1}}); }),
              "normals: wanted as many as points, 2, got 1");
}

TEST(Radii, CanBeCancelled) {
    const std::vector<Vec3> points = samples(100, on_sphere, 9);
    EXPECT_THROW(estimate_radii(points, {}, [](std::size_t, std::size_t) { return false; }), Cancelled);
}

}  // namespace
}  // namespace surflux
