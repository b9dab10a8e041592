#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <numeric>

#include "shapes.h"
#include "surflux/area/coincidence.h"
#include "surflux/area/effective_area.h"
#include "surflux/area/pieces.h"
#include "surflux/core/random.h"
#include "surflux/neighbors/radii.h"
#include "surflux/trace/tracer.h"

namespace surflux {
namespace {

using shapes::add_rectangle;
using shapes::scene_of;

const Vec3 x{1, 0, 0}, y{0, 1, 0}, up{0, 0, 1};

Surfels rectangle(const Vec3& corner, const Vec3& u, const Vec3& v, int m = 1, int n = 1) {
    Surfels s;
    add_rectangle(s, corner, u, v, m, n);
    shapes::finish(s, 0.5, 0.0);
    return s;
}

double sum(const Surfels& s) { return std::accumulate(s.areas.begin(), s.areas.end(), 0.0); }
double area(const Scene& scene) { return sum(scene.surfels); }

std::vector<std::uint32_t> first(std::uint32_t n) {
    std::vector<std::uint32_t> out(n);
    std::iota(out.begin(), out.end(), 0u);
    return out;
}

// Random points of a rectangle that faces up, with the areas that they have by themselves.
Surfels strewn(const Vec3& corner, double width, std::size_t n, std::uint64_t seed) {
    Random random(seed);
    Surfels s;
    for (std::size_t k = 0; k < n; ++k) {
        const double u = random.uniform(), v = random.uniform();
        s.positions.push_back(corner + width * u * x + v * y);
        s.normals.push_back(up);
    }
    shapes::finish(s, 0.5, 0.0);
    s.radii = estimate_radii(s.positions);
    s.areas = effective_areas(s, {});
    return s;
}

// Objects of the points of one cloud, dealt out at random to the first with probability `share`, else to the others.
std::vector<Surfels> slices(const Surfels& cloud, std::size_t count, double share, std::uint64_t seed) {
    Random random(seed);
    std::vector<std::vector<std::uint32_t>> of(count);
    for (std::uint32_t i = 0; i < cloud.size(); ++i) {
        const double at = random.uniform();
        const double rest = (at - share) / (1.0 - share) * static_cast<double>(count - 1);
        of[at < share ? 0 : std::min(count - 1, 1 + static_cast<std::size_t>(rest))].push_back(i);
    }
    std::vector<Surfels> out;
    for (const auto& indices : of) out.push_back(select(cloud, indices));
    return out;
}

TEST(Coincidence, AreasOfPatchesThatOverlapAreThatOfTheirUnion) {
    // A unit square turned by 45 degrees in the middle of one, whose four corners are cut off by its edges: what the
    // two share is the regular octagon of inradius 1/2, of area 2 (sqrt 2 - 1).
    const double h = std::sqrt(0.5);
    const Vec3 u{h, h, 0}, v{-h, h, 0}, middle{0.5, 0.5, 0};
    const double octagon = 2.0 * (std::sqrt(2.0) - 1.0);
    for (const Vec3& offset : {Vec3{}, Vec3{5e5, 5e5, 0}}) {
        Scene scene = scene_of({rectangle(offset, x, y), rectangle(offset + middle - 0.5 * (u + v), u, v)});
        const Coincidence found = find_coincidence(scene);
        ASSERT_EQ(found.covers.size(), 1u);
        EXPECT_EQ(found.covers[0].below, 0u);
        EXPECT_EQ(found.covers[0].above, 1u);
        EXPECT_NEAR(found.uncovered[0], 1.0 - octagon, 1e-9);
        EXPECT_EQ(found.uncovered[1], 1.0);
        count_once(scene, found);
        EXPECT_NEAR(area(scene), 2.0 - octagon, 1e-9);
    }
}

TEST(Coincidence, LayersAreCountedByTheirUnionHoweverMany) {
    // Three squares of side 1, each moved on by .3: 1 + 2 * .3.
    Scene scene = scene_of({rectangle({}, x, y), rectangle({0.3, 0, 0}, x, y), rectangle({0.6, 0, 0}, x, y)});
    count_once(scene, find_coincidence(scene));
    EXPECT_NEAR(area(scene), 1.6, 1e-12);
}

TEST(Coincidence, WorkGrowsWithThePatchesOverALargeOne) {
    // Four times as many patches in a corner of a floor of one: n log n is 4.6 times the work, cutting each from all
    // that the others left 14 and more.
    for (const double height : {0.0, 1e-5}) {
        double fastest[2] = {1e300, 1e300};
        for (int run = 0; run < 3; ++run)
            for (int k = 0; k < 2; ++k) {
                const int side = k == 0 ? 50 : 100;
                const Scene scene =
                    scene_of({rectangle({}, x, y), rectangle({0, 0, height}, 0.3 * x, 0.3 * y, side, side)});
                const std::clock_t before = std::clock();
                const Coincidence found = find_coincidence(scene);
                fastest[k] = std::min(fastest[k], static_cast<double>(std::clock() - before));
                if (height == 0.0) {
                    EXPECT_EQ(found.covers.size(), static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
                    EXPECT_NEAR(found.uncovered[0], 0.91, 1e-9);
                } else {
                    ASSERT_EQ(found.close_sheets.size(), 1u);
                    EXPECT_NEAR(found.close_sheets[0].share, 0.09, 1e-9);
                }
            }
        EXPECT_LT(fastest[1], 8.0 * fastest[0]) << height;
    }
}

TEST(Pieces, TrianglesTakeInTurnWhatTheyTakeOneByOne) {
    // Strewn over a square far from the origin, so that many overlap, some slivers, some piled up.
    Random random(3);
    const Vec3 origin{1e3, -2e3, 5.0};
    const auto place = [&] { return origin + Vec3{random.uniform(), random.uniform(), 0.0}; };
    std::vector<Triangle> triangles;
    for (std::uint32_t t = 0; t < 300; ++t) {
        if (t % 10 == 9) {
            triangles.push_back(triangles.back());
        } else {
            const Vec3 at = place();
            const double size = t % 7 == 0 ? 0.5 : 0.1;
            Triangle next{at, at + size * (place() - origin), at + size * (place() - origin), 0};
            if (cross_of(next).z < 0.0) std::swap(next.b, next.c);
            triangles.push_back(next);
        }
        triangles.back().surfel = t;
    }
    const Triangle floor[2] = {{origin, origin + x, origin + x + y, 0}, {origin, origin + x + y, origin + y, 0}};
    Pieces rest = pieces_of(floor, floor + 2, origin);
    std::vector<double> taken(triangles.size(), 0.0);
    const double left = take_in_turn(rest, triangles, origin, -1e-3, 1e-3, taken);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const double before = area_of(rest);
        rest = without(rest, triangles[t], origin, -1e-3, 1e-3);
        EXPECT_NEAR(taken[t], before - area_of(rest), 1e-10) << t;
    }
    EXPECT_NEAR(left, area_of(rest), 1e-10);
    EXPECT_GT(left, 0.05);
    EXPECT_LT(left, 0.95);
}

TEST(Coincidence, NeighboursFoldsAndBacksDoNotCoincide) {
    // A box closed by patches that share edges, one of them cut into 5 x 7; its outside, which faces the other way.
    Surfels inside = shapes::cube_inside(3, 0.5, 0.0), outside = inside;
    for (Vec3& n : outside.normals) n = -n;
    for (Triangle& t : outside.triangles) std::swap(t.b, t.c);
    Scene scene = scene_of({inside, outside, rectangle({1, 0, 0}, x, y, 5, 7)});
    const Coincidence found = find_coincidence(scene);
    EXPECT_TRUE(found.covers.empty());
    count_once(scene, found);
    EXPECT_NEAR(area(scene), 13.0, 1e-12);
    // Near, and farther or not than the rounding of places, twice 2^-22 of the diagonal sqrt 2: 6.7e-7.
    scene = scene_of({rectangle({}, x, y), rectangle({0, 0, 9e-7}, x, y)});
    EXPECT_TRUE(find_coincidence(scene).covers.empty());
    scene = scene_of({rectangle({}, x, y), rectangle({0, 0, 5e-7}, x, y)});
    EXPECT_EQ(find_coincidence(scene).covers.size(), 1u);
}

TEST(Coincidence, RaysSeeThePatchOnTopAndNoneOfThemHidesAnother) {
    const Vec3 offsets[] = {{}, {0.137, 0.291, 0.713}, {-3e3, 2e3, 1e3}};
    for (const Vec3& o : offsets) {
        Scene scene = scene_of({rectangle(o, x, y, 4, 4), rectangle(o + Vec3{0.3, 0.3, 0}, 0.4 * x, 0.4 * y),
                                rectangle(o + Vec3{0, 0, 1}, y, x)});
        const std::uint32_t carpet = 16, ceiling = 17;
        count_once(scene, find_coincidence(scene));
        const Tracer tracer(scene);
        Random random(1);
        for (int k = 0; k < 2000; ++k) {
            const Vec3 from = o + Vec3{random.uniform(), random.uniform(), 1.0};
            const double s = random.uniform(), t = random.uniform();
            const Vec3 to = o + Vec3{s, t, 0.0};
            const bool on_carpet = s > 0.3 && s < 0.7 && t > 0.3 && t < 0.7;
            const Hit hit = tracer.closest({tracer.on(ceiling, from), normalized(to - from)});
            ASSERT_TRUE(hit.front);
            ASSERT_EQ(hit.surfel == carpet, on_carpet) << s << " " << t;
            const auto floor = static_cast<std::uint32_t>(4 * static_cast<int>(4 * s) + static_cast<int>(4 * t));
            for (const std::uint32_t i : {floor, carpet}) {
                if (i == carpet && !on_carpet) continue;
                ASSERT_TRUE(tracer.free(segment(tracer.on(ceiling, from), to, i)));
                ASSERT_TRUE(tracer.free(segment(tracer.on(i, to), from, ceiling)));
                ASSERT_TRUE(tracer.free(segment(tracer.on(i, to), o + Vec3{0.5, 0.5, 0.9})));
                ASSERT_EQ(tracer.closest({tracer.on(i, to), normalized(from - to)}).surfel, ceiling);
            }
        }
    }
}

TEST(Coincidence, TwoCloudsOfOneSphereHaveItsAreaOnceAndSeeTheSky) {
    // The Fibonacci points of a sphere, and others of the same.
    const Surfels one = shapes::sphere(800, 1.0, 1.0, 0.5, 0.0), other = shapes::sphere(1300, 1.0, 1.0, 0.5, 0.0);
    Scene scene = scene_of({one, other});
    const Coincidence found = find_coincidence(scene);
    ASSERT_EQ(found.disks.overlaps.size(), 1u);
    EXPECT_EQ(found.disks.overlaps[0].joined, 2100u);
    EXPECT_EQ(found.disks.overlaps[0].layered, 0u);
    count_once(scene, found);
    EXPECT_NEAR(area(scene) / (0.5 * (sum(one) + sum(other))), 1.0, 1e-3);
    // The more points one has, the larger its part: in proportion, but that places of the two go together at the poles.
    EXPECT_NEAR(sum(select(scene.surfels, first(800))) / area(scene), 800.0 / 2100.0, 0.05);
    const Tracer tracer(scene);
    for (std::uint32_t i = 0; i < scene.surfels.size(); ++i) {
        EvenPoints even(2, 0, i);
        const Frame frame = frame_around(scene.surfels.normals[i]);
        for (int k = 0; k < 64; ++k) {
            const double* u = even.next();
            const Vec3 d = frame.to_world(square_to_cosine_hemisphere(u[0], u[1]));
            ASSERT_TRUE(tracer.free({tracer.on(i, scene.surfels.positions[i]), d}));
        }
    }
}

TEST(Coincidence, SlicesOfOneCloudHaveTogetherWhatTheWholeHas) {
    for (std::uint64_t seed = 0; seed < 3; ++seed)
        for (const Surfels& whole : {strewn({}, 1.0, 3000, seed), shapes::sphere(2000, 1.0, 1.0, 0.5, 0.0)})
            for (const double share : {0.1, 1.0 / 3.0, 0.5}) {
                std::vector<Surfels> parts = slices(whole, share > 0.1 && share < 0.5 ? 3 : 2, share, seed);
                // Areas that are parts of the whole's stay.
                Scene scene = scene_of(parts);
                const Coincidence found = find_coincidence(scene);
                EXPECT_EQ(count_once(scene, found).size(), parts.size());
                EXPECT_NEAR(area(scene) / sum(whole), 1.0, 1e-12);
                for (Surfels& part : parts) part.areas = effective_areas(part, {});
                scene = scene_of(parts);
                const double apart = area(scene);
                EXPECT_GT(apart, 1.1 * sum(whole));
                EXPECT_TRUE(count_once(scene, found).empty());
                EXPECT_NEAR(area(scene) / sum(whole), 1.0, 0.01) << share << " " << seed;
            }
}

TEST(Coincidence, CloudsThatOverlapInPartHaveTheAreaOfTheirUnion) {
    for (std::uint64_t seed = 0; seed < 3; ++seed)
        for (const std::size_t n : {4000u, 1000u, 400u})
            for (const double begin : {0.0, 0.5, 0.9}) {
                Scene scene = scene_of({strewn({}, 1.0, 4000, seed), strewn({begin, 0.0, 0.0}, 1.0, n, 100 + seed)});
                count_once(scene, find_coincidence(scene));
                EXPECT_NEAR(area(scene) / (1.0 + begin), 1.0, n == 400 ? 0.025 : 0.015) << n << " " << begin;
            }
}

TEST(Coincidence, APileInOneOfTwoCloudsIsOneDiskOfIt) {
    // 100 000 dropped returns: each with each would take hours.
    constexpr std::size_t high = 100000;
    const Surfels one = shapes::sphere(800, 1.0, 1.0, 0.5, 0.0), other = shapes::sphere(1300, 1.0, 1.0, 0.5, 0.0);
    std::vector<std::uint32_t> indices(800);
    std::iota(indices.begin(), indices.end(), 0u);
    indices.resize(800 + high, 0u);
    Surfels piled = select(one, indices);
    for (std::size_t k = 0; k < piled.size(); ++k)
        if (indices[k] == 0) piled.areas[k] /= static_cast<double>(high + 1);
    Scene scene = scene_of({piled, other}), without_pile = scene_of({one, other});
    const Coincidence found = find_coincidence(scene), alone = find_coincidence(without_pile);
    ASSERT_EQ(found.disks.overlaps.size(), 1u);
    EXPECT_EQ(found.disks.overlaps[0].joined, 2100u + high);
    EXPECT_EQ(found.disks.spread[800 + high - 1], found.disks.spread[0]);
    EXPECT_EQ(found.disks.spread[0], alone.disks.spread[0]);
    count_once(scene, found);
    count_once(without_pile, alone);
    EXPECT_NEAR(area(scene) / area(without_pile), 1.0, 1e-9);
}

TEST(Coincidence, AllOfItCanBeCancelled) {
    const Scene clouds = scene_of({shapes::sphere(800, 1.0, 1.0, 0.5, 0.0), shapes::sphere(1300, 1.0, 1.0, 0.5, 0.0)});
    const Coincidence found = find_coincidence(clouds);
    std::size_t calls = 0, ends = 0;
    const auto count = [&](std::size_t done, std::size_t total) { return ++calls, ends += done == total, true; };
    find_coincidence(clouds, count);
    EXPECT_GE(ends, 3u);  // who meets whom, spreads, meetings
    for (std::size_t last = 1; last <= calls; ++last) {
        std::size_t left = last;
        EXPECT_THROW(find_coincidence(clouds, [&](std::size_t, std::size_t) { return --left > 0; }), Cancelled);
    }
    Scene scene = clouds;
    EXPECT_THROW(count_once(scene, found, [](std::size_t, std::size_t) { return false; }), Cancelled);
}

}  // namespace
}  // namespace surflux
