#include <gtest/gtest.h>

#include <numeric>
#include <tuple>

#include "shapes.h"
#include "surflux/area/border.h"
#include "surflux/area/effective_area.h"
#include "surflux/area/polar_grid.h"
#include "surflux/area/shares.h"
#include "surflux/area/surface_fit.h"
#include "surflux/core/error.h"
#include "surflux/core/gauss_legendre.h"
#include "surflux/core/parallel.h"
#include "surflux/core/random.h"

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
        EXPECT_GT(sum(effective_areas(s, paper)) / (4.0 * pi), n == 160u ? 1.04 : 1.01);
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

// A 11 x 11 lattice on the plane through `corner` along u and v, the first row and column half a cell inside.
void add_lattice(Surfels& s, const Vec3& corner, const Vec3& u, const Vec3& v) {
    for (int a = 0; a < 11; ++a)
        for (int b = 0; b < 11; ++b) {
            s.positions.push_back(corner + (0.1 * a + 0.05) * u + (0.1 * b + 0.05) * v);
            s.normals.push_back(cross(u, v));
            s.radii.push_back(0.15);
        }
    shapes::finish(s, 0.5, 0.0);
}

TEST(EffectiveArea, EndsAtACrease) {
    // Two faces that meet at a right angle, seen from without and from within: every surfel in their inner rows has its
    // cell, those along the crease too.
    for (double side : {1.0, -1.0}) {
        Surfels s;
        add_lattice(s, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
        add_lattice(s, {0, 0, 0}, {0, 1, 0}, {0, 0, -1});
        for (std::size_t k = 121; k < 242; ++k) s.normals[k] = {-1, 0, 0};
        for (Vec3& n : s.normals) n = side * n;
        const std::vector<double> areas = effective_areas(s, {});
        for (std::size_t a : {0u, 1u, 5u})
            for (std::size_t b : {4u, 5u, 6u}) {
                EXPECT_NEAR(areas[11 * a + b], 0.01, 1e-4) << side << " " << a << " " << b;
                EXPECT_NEAR(areas[121 + 11 * b + a], 0.01, 1e-4) << side << " " << a << " " << b;
            }
    }
}

TEST(EffectiveArea, EndsWhereTheSamplingEnds) {
    // The lattice's outermost rows are taken for the border, and .05 of the spacing beyond them: the mean distance of
    // the six nearest is .1 (4 + 2 sqrt 2) / 6 inside.
    Surfels s;
    add_lattice(s, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const std::vector<double> areas = effective_areas(s, {});
    const double margin = 0.05 * 0.1 * (4.0 + 2.0 * std::sqrt(2.0)) / 6.0;
    EXPECT_NEAR(areas[60], 0.01, 1e-4);
    EXPECT_NEAR(areas[5], 0.1 * (0.05 + margin), 4e-4);
    EXPECT_NEAR(sum(areas), (1.0 + 2.0 * margin) * (1.0 + 2.0 * margin), 0.01);
}

TEST(EffectiveArea, KeepsStackedSheetsApart) {
    // Same lattice, .1 higher and facing the same way: more than .35 (R + R). At .02 it is noise of one surface (and
    // the border's margin smaller, for the nearest is at .02).
    Surfels s;
    add_lattice(s, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const double one = sum(effective_areas(s, {}));
    for (const auto& [height, sheets, within] : {std::tuple(0.12, 2.0, 1e-3), std::tuple(0.02, 1.0, 1e-2)}) {
        Surfels two = s;
        add_lattice(two, {0, 0, height}, {1, 0, 0}, {0, 1, 0});
        EXPECT_NEAR(sum(effective_areas(two, {})), sheets * one, within * one) << height;
    }
}

TEST(EffectiveArea, DoesNotFollowNoise) {
    // A sphere of 2000 jittered by a tenth of its spacing along the normals, which turn by 10 degrees.
    Surfels s = shapes::sphere(2000, 1.0, 1.0, 0.5, 0.0);
    for (std::size_t i = 0; i < s.size(); ++i) {
        Random random(3, i);
        const Frame frame = frame_around(s.normals[i]);
        const double phi = 2.0 * pi * random.uniform(), tilt = 10.0 * pi / 180.0;
        s.positions[i] *= 1.0 + 0.0079 * std::sqrt(12.0) * (random.uniform() - 0.5);
        s.normals[i] = frame.to_world({std::sin(tilt) * std::cos(phi), std::sin(tilt) * std::sin(phi), std::cos(tilt)});
    }
    s.areas.clear();
    EXPECT_NEAR(sum(effective_areas(s, {})) / (4.0 * pi), 1.0, 5e-3);
    AreaOptions paper;
    paper.method = AreaMethod::paper;
    EXPECT_GT(sum(effective_areas(s, paper)) / (4.0 * pi), 1.015);
}

TEST(AreaShares, SumToOneAndIntegrateToTheArea) {
    Surfels s = shapes::sphere(640, 1.0, 1.0, 0.5, 0.0);
    s.areas.clear();
    for (AreaMethod method : {AreaMethod::paper, AreaMethod::curved}) {
        AreaOptions options;
        options.method = method;
        options.resolution = 128;
        const std::vector<double> areas = effective_areas(s, options);
        for (std::size_t i : {0u, 77u, 639u}) {
            const DiskShares found = area_shares(s, i, options);
            EXPECT_EQ(found.members[0], i);
            EXPECT_EQ(found.area, areas[i]);
            const std::size_t pixels = 128 * 128;
            ASSERT_EQ(found.shares.size(), pixels * found.members.size());
            double own = 0.0;
            for (std::size_t p = 0; p < pixels; ++p) {
                const double x = (static_cast<double>(p % 128) + 0.5) / 64.0 - 1.0,
                             y = (static_cast<double>(p / 128) + 0.5) / 64.0 - 1.0;
                if (std::isnan(found.shares[p])) {
                    EXPECT_GT(x * x + y * y, 0.97);
                    continue;
                }
                double all = 0.0;
                for (std::size_t k = 0; k < found.members.size(); ++k) all += found.shares[k * pixels + p];
                EXPECT_NEAR(all, 1.0, 1e-12);
                // On a sphere of radius 1 the element over the plane is 1 / n_z.
                const double r2 = (x * x + y * y) * found.extent * found.extent;
                own += found.shares[p] * (method == AreaMethod::curved ? 1.0 / std::sqrt(1.0 - r2) : 1.0);
            }
            own *= std::pow(found.extent / 64.0, 2);
            // D04's element is the neighbours' mean, up to 1 / cos of the angle between the normals.
            EXPECT_NEAR(own, found.area, (method == AreaMethod::curved ? 5e-4 : 0.05) * found.area);
        }
    }
}

TEST(AreaShares, RefusesWhatHasNoDisk) {
    const Surfels s = shapes::cube_inside(2, 0.5, 0.0);
    EXPECT_THROW(area_shares(s, 3, {}), ArgumentError);
    EXPECT_THROW(area_shares(s, s.size(), {}), ArgumentError);
}

TEST(PolarGrid, GaussPointsIntegratePolynomials) {
    // n points are exact up to degree 2 n - 1, and not beyond.
    std::vector<double> nodes, weights;
    for (int n : {1, 2, 5, 16, 256}) {
        gauss_legendre(n, nodes, weights);
        const auto integral = [&](int degree) {
            double total = 0.0;
            for (std::size_t k = 0; k < nodes.size(); ++k) total += weights[k] * std::pow(nodes[k], degree);
            return total * (degree + 1);
        };
        for (int degree : {0, n, 2 * n - 1}) EXPECT_NEAR(integral(degree), 1.0, 1e-12) << n << " " << degree;
        if (n <= 5) {
            EXPECT_GT(std::abs(integral(2 * n) - 1.0), 1e-6) << n;
        }
    }
}

TEST(PolarGrid, WeightsAddUpToTheDisk) {
    for (int resolution : {4, 5, 32, 512}) {
        const PolarGrid grid(resolution);
        double ring = 0.0;
        for (float w : grid.weight) ring += static_cast<double>(w);
        EXPECT_NEAR(ring * grid.directions, pi, 1e-5);
    }
}

TEST(HullSides, HoldAllPointsAndTouchTheOutermost) {
    std::vector<HalfPlane> sides;
    std::vector<Point2> line{{0, 0}, {1, 1}, {2, 2}};
    hull_sides(line, sides);
    EXPECT_TRUE(sides.empty());
    std::vector<Point2> points;
    for (std::uint64_t k = 0; k < 200; ++k) {
        Random random(1, k);
        points.push_back({random.uniform(), 2.0 * random.uniform()});
    }
    hull_sides(points, sides);
    ASSERT_GE(sides.size(), 3u);
    for (const HalfPlane& h : sides) {
        EXPECT_NEAR(std::hypot(h.x, h.y), 1.0, 1e-12);
        double farthest = -1e9;
        for (const Point2& p : points) farthest = std::max(farthest, h.x * p.x + h.y * p.y);
        EXPECT_NEAR(farthest, h.limit, 1e-12);
    }
}

TEST(SharpenCorners, FillsABevelUpToTheTolerance) {
    // The unit square without a corner: the bevel is .2 sqrt(1/2) deep.
    const auto sides = [] {
        std::vector<Point2> points{{0, 0}, {0.8, 0}, {1, 0.2}, {1, 1}, {0, 1}};
        std::vector<HalfPlane> found;
        hull_sides(points, found);
        return found;
    };
    std::vector<HalfPlane> kept = sides();
    EXPECT_EQ(kept.size(), 5u);
    sharpen_corners(kept, 0.14);
    EXPECT_EQ(kept.size(), 5u);
    sharpen_corners(kept, 0.15);
    EXPECT_EQ(kept.size(), 4u);
    for (const HalfPlane& h : kept) EXPECT_NEAR(std::abs(h.x) + std::abs(h.y), 1.0, 1e-12);
}

TEST(SurfaceFit, IsExactOnSpheresAndPlanes) {
    // From without and within, and on a plane, with any weights.
    for (double curvature : {0.4, -0.5, 0.0}) {
        std::vector<OrientedPoint> points;
        for (std::uint64_t k = 0; k < 7; ++k) {
            Random random(2, k);
            const double x = 2.0 * random.uniform() - 1.0, y = 2.0 * random.uniform() - 1.0, t = curvature;
            const double nz = std::sqrt(1.0 - t * t * (x * x + y * y));
            const double z = t == 0.0 ? 0.0 : (nz - 1.0) / t;
            points.push_back({{x, y, z}, {t * x, t * y, nz}, 0.2 + random.uniform()});
        }
        const SurfaceModel m = fit_surface(points);
        EXPECT_NEAR(m.kxx, curvature, 1e-5);
        EXPECT_NEAR(m.kyy, curvature, 1e-5);
        EXPECT_NEAR(m.kxy, 0.0, 1e-5);
        EXPECT_NEAR(m.z0, 0.0, 1e-5);
        for (const OrientedPoint& p : points) {
            EXPECT_NEAR(m.height(p.position.x, p.position.y), p.position.z, 1e-5);
            EXPECT_NEAR(m.stretch(p.position.x, p.position.y), 1.0 / p.normal.z, 1e-4);
        }
    }
    const SurfaceModel alone = fit_surface({});
    EXPECT_EQ(alone.height(0.3, 0.4), 0.0);
    EXPECT_EQ(alone.stretch(0.3, 0.4), 1.0);
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
