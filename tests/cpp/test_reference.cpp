#include <gtest/gtest.h>

#include "refusal.h"
#include "shapes.h"
#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/reference/glossy_reference.h"
#include "surflux/reference/reference.h"
#include "surflux/trace/tracer.h"

namespace surflux {
namespace {

using shapes::scene_of;

const Vec3 up{0, 0, 1}, down{0, 0, -1};

Surfels square(double height, double side, bool facing_up, double rho = 0.5, double emission = 0.0) {
    Surfels s;
    const Vec3 x{side, 0, 0}, y{0, side, 0}, corner{-0.5 * side, -0.5 * side, height};
    shapes::add_rectangle(s, corner, facing_up ? x : y, facing_up ? y : x, 1, 1);
    shapes::finish(s, rho, emission);
    return s;
}

TEST(Departure, BelongsToTheSurfaceThatFacesItsWay) {
    const Tracer disks(scene_of({shapes::disk({0, 0, 0}, up, 1.0), shapes::disk({0, 0, 0.1}, up, 1.0)}));
    EXPECT_EQ(disks.departure({0.5, 0, 0.0}, up).surfel, 0u);
    EXPECT_EQ(disks.departure({0.5, 0, 0.04}, up).surfel, 0u);
    EXPECT_EQ(disks.departure({0.5, 0, 0.06}, up).surfel, 1u);
    EXPECT_EQ(disks.departure({0.5, 0, 0.4}, up).surfel, 1u);
    EXPECT_EQ(disks.departure({0.5, 0, -0.4}, up).surfel, 0u);
    EXPECT_EQ(disks.departure({0.5, 0, 0.0}, down).surfel, Hit::none);
    EXPECT_EQ(disks.departure({0.5, 0, 0.7}, up).surfel, Hit::none);
    EXPECT_EQ(disks.departure({1.5, 0, 0.0}, up).surfel, Hit::none);

    const Tracer patch(scene_of({square(0.0, 1.0, true)}));
    EXPECT_EQ(patch.departure({0.2, 0.1, 0.0}, up).surfel, 0u);
    EXPECT_EQ(patch.departure({0.2, 0.1, 1e-3}, up).surfel, Hit::none);

    const Tracer sheet(scene_of({two_sided(shapes::disk({0, 0, 0}, up, 1.0))}));
    EXPECT_EQ(sheet.departure({0.5, 0, 0.0}, up).surfel, 0u);
    EXPECT_EQ(sheet.departure({0.5, 0, 0.0}, down).surfel, 1u);
}

TEST(Departure, IgnoresWhatStandsOffItsOwnSurfaceAlone) {
    // A point under a disk of its own object and under one of another: both are crossed from behind.
    Surfels own = shapes::disk({0, 0, 0}, up, 0.2);
    const Surfels other = shapes::disk({0.1, 0, 0.03}, up, 0.2);
    const Tracer two(scene_of({own, other}));
    EXPECT_FALSE(two.free({two.departure({0.05, 0, 0}, up), up}));
    Scene one;
    append(one, own);
    append(one, other);
    one.object = {0, 0};
    const Tracer same(one);
    EXPECT_TRUE(same.free({same.departure({0.05, 0, 0}, up), up}));
    // From the front the same disk is an obstacle, and so it is for a point in the air.
    EXPECT_FALSE(same.free({{{0.05, 0, 0.1}, up, 0}, down}));
    EXPECT_FALSE(same.free({{{0.05, 0, -0.3}, up, Hit::none}, up}));
}

TEST(Departure, RoundingDoesNotPutItBehindItsSurface) {
    Surfels floor;  // far from the origin, and points on the edges of its patches
    shapes::add_rectangle(floor, {1e5, 2e5, 3e5}, {0, 1, 0}, {0, 0, 1}, 3, 3);
    shapes::finish(floor, 0.5, 0.0);
    const Tracer tracer(scene_of({floor}));
    const Vec3 n{1, 0, 0};
    for (int a = 0; a <= 6; ++a)
        for (int b = 0; b <= 6; ++b) {
            const Vec3 at{1e5, 2e5 + a / 6.0, 3e5 + b / 6.0};
            for (const Vec3& d : {Vec3{1, 0, 0}, Vec3{0.01, 1, 0}, Vec3{0.01, -1, 1}, Vec3{1e-4, -1, -1}})
                EXPECT_TRUE(tracer.free({tracer.departure(at, n), normalized(d)})) << a << " " << b;
        }
    // What lies on it face to face covers it.
    const Tracer covered(scene_of({square(0.0, 1.0, true), square(0.0, 1.0, false)}));
    EXPECT_FALSE(covered.free({covered.departure({0.2, 0.1, 0.0}, up), up}));
}

TEST(Rays, ManyAtOnceFindWhatEachFindsAlone) {
    const Surfels ball = shapes::sphere(300, 1.0, -1.0, 0.5, 0.0);
    const Tracer tracer(scene_of({ball, square(0.3, 0.5, true)}));
    std::vector<Ray> rays;
    for (std::uint32_t k = 0; k < 300; ++k) {
        Random random(1, k);
        const Frame frame = frame_around(ball.normals[k]);
        const double s = random.uniform();
        const Vec3 d = frame.to_world(square_to_cosine_hemisphere(s, random.uniform()));
        rays.push_back({{ball.positions[k], ball.normals[k], k}, d, k % 3 == 0 ? 0.2 : Ray{}.length});
    }
    std::vector<Hit> hits;
    std::vector<char> free;
    tracer.closest(rays, hits);
    tracer.free(rays, free);
    std::size_t met = 0;
    for (std::uint32_t k = 0; k < 300; ++k) {
        const Hit alone = tracer.closest({tracer.on(k, rays[k].from.position), rays[k].direction});
        const bool within = alone && alone.distance <= rays[k].length;
        EXPECT_EQ(bool(hits[k]), within) << k;
        EXPECT_EQ(bool(free[k]), !within) << k;
        if (!within || !hits[k]) continue;
        ++met;
        EXPECT_EQ(hits[k].surfel, alone.surfel);
        EXPECT_EQ(hits[k].front, alone.front);
        EXPECT_EQ(hits[k].distance, alone.distance);
    }
    EXPECT_GT(met, 190u);
}

// Mean z-score squared of the first channel against one expected value; every |z| is below 4.5.
double mean_square(const Reference& r, double expected) {
    double sum = 0.0;
    for (std::size_t k = 0; k < r.irradiance.size(); ++k) {
        const double z = (r.irradiance[k].x - expected) / r.error[k].x;
        EXPECT_LT(std::abs(z), 4.5) << k;
        sum += z * z;
    }
    return sum / static_cast<double>(r.irradiance.size());
}

TEST(Reference, FurnaceIsRightAndSoIsItsError) {
    const Surfels cube = shapes::cube_inside(4, 0.7, 1.0);
    const Reference r = reference_irradiance(scene_of({cube}), cube.positions, cube.normals, {1024, 3});
    EXPECT_EQ(r.batches, 32u);
    // 96 squares of Student's t with 31 degrees of freedom: mean 1.07, standard deviation .17.
    EXPECT_NEAR(mean_square(r, 1.0 / 0.3), 1.07, 0.6);
}

TEST(Reference, AimingAtEmittersChangesNothingButTheNoise) {
    const Surfels lamp = square(1.0, 0.1, false, 0.3, 50.0), floor = square(0.0, 4.0, true, 0.6);
    const Scene scene = scene_of({floor, lamp, shapes::disk({0.05, 0.02, 0.8}, down, 0.02)});
    std::vector<Vec3> points, normals;
    for (int k = 0; k < 40; ++k) points.push_back({-0.5 + k / 40.0, 0.1, 0.0}), normals.push_back(up);
    const Reference by_chance = reference_irradiance(scene, points, normals, {16384, 0, 0.0});
    const Reference aimed = reference_irradiance(scene, points, normals, {4096, 1, 1.0});
    double sum = 0.0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const double variance = aimed.error[k].x * aimed.error[k].x + by_chance.error[k].x * by_chance.error[k].x;
        const double z = (aimed.irradiance[k].x - by_chance.irradiance[k].x) / std::sqrt(variance);
        EXPECT_LT(std::abs(z), 4.5);
        sum += z * z;
        EXPECT_LT(aimed.error[k].x, 0.5 * by_chance.error[k].x);
    }
    EXPECT_NEAR(sum / 40.0, 1.0, 0.7);
}

TEST(Reference, SameForAnyNumberOfThreads) {
    const Surfels ball = shapes::sphere(200, 1.0, -1.0, 0.8, 0.1);
    const Scene scene = scene_of({ball}, {PointLight{{0.1, 0.2, 0.3}, {1, 2, 3}}});
    const auto run = [&](int threads) {
        const ThreadLimit limit(threads);
        return reference_irradiance(scene, ball.positions, ball.normals, {100, 5});
    };
    const Reference one = run(1), four = run(4);
    EXPECT_EQ(one.rays, four.rays);
    for (std::size_t k = 0; k < ball.size(); ++k) {
        EXPECT_EQ(one.irradiance[k], four.irradiance[k]);
        EXPECT_EQ(one.error[k], four.error[k]);
    }
}

TEST(Reference, BlackSceneAndNoPoints) {
    const Scene dark = scene_of({shapes::cube_inside(1, 0.5, 0.0)});
    const Reference r = reference_irradiance(dark, {{0.5, 0.5, 0.0}}, {up}, {});
    EXPECT_EQ(r.irradiance[0], Vec3{});
    EXPECT_EQ(r.error[0], Vec3{});
    EXPECT_TRUE(reference_irradiance(dark, {}, {}, {}).irradiance.empty());
    EXPECT_THROW(reference_irradiance(dark, {{0.5, 0.5, 0.0}}, {}, {}), ArgumentError);
    EXPECT_THROW(reference_irradiance(dark, {{0.5, 0.5, 0.0}}, {up}, {15, 0}), ArgumentError);
    EXPECT_THROW(
        reference_irradiance(dark, {{0.5, 0.5, 0.0}}, {up}, {}, [](std::size_t, std::size_t) { return false; }),
        Cancelled);
}

TEST(GlossyReference, RefusesWhatDoesNotFitTogether) {
    const Scene scene = scene_of({square(0.0, 1.0, true)});
    const auto said = [&](const GlossyPlaces& places) {
        return refusal([&] { reference_radiance(scene, places, {}); });
    };
    EXPECT_EQ(said({{{}, {}}, {up, up}, {up}, {}, {}, {}}),
              "normals, directions: wanted one for each of the 2 points, got 2 and 1");
    EXPECT_EQ(said({{{}, {}}, {up, up}, {up, up}, {}, {{}}, {}}),
              "materials: wanted one for each of the 2 points, or none");
    EXPECT_EQ(said({{{}, {0, 0, 3}}, {up, up}, {up, up}, {}, {}, {}}),
              "points: 1 lies on no surfel: give reflectance, specular and exponent of all");
}

}  // namespace
}  // namespace surflux
