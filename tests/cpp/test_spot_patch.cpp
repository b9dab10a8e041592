#include <gtest/gtest.h>

#include "shapes.h"
#include "surflux/lights/direct.h"
#include "surflux/lights/polygon.h"
#include "surflux/lights/spot_patch.h"

namespace surflux {
namespace {

const Vec3 light{0.43, 0.31, 0.62};

SpotCone cone_of(double cone, double penumbra, const Vec3& axis) {
    return SpotCone(SpotLight{light, normalized(axis), {1, 1, 1}, cone, penumbra});
}

double power_of(const SpotCone& cone, const Surfels& s) {
    double sum = 0.0;
    for (const Triangle& t : s.triangles) sum += spot_power(light, cone, t);
    return sum;
}

const double cones[][2] = {{0.05, 0.0},   {1.0, 0.2},     {3.0, 3.0},   {45.0, 5.0},
                           {118.0, 30.0}, {150.0, 150.0}, {300.0, 90.0}};

TEST(SpotPatch, ABoxAroundASpotHasAllOfItsPower) {
    for (const auto& [angle, penumbra] : cones)
        for (const Vec3& axis : {Vec3{0, 0, -1}, Vec3{1, 0.2, -0.3}, Vec3{-0.57, 0.31, 0.38}})
            for (const int n : {1, 4}) {
                const SpotCone cone = cone_of(angle, penumbra, axis);
                const double all = 2.0 * pi * cone.within(pi);
                EXPECT_NEAR(power_of(cone, shapes::cube_inside(n, 0.5, 0.0)) / all, 1.0, 1e-7)
                    << angle << " " << penumbra << " " << n;
            }
}

TEST(SpotPatch, ACapsPowerIsThatOfItsSolidAngle) {
    // Without a penumbra: 2 pi (1 - cos of half the cone). A spot of the whole sphere is a point light.
    EXPECT_NEAR(2.0 * pi * cone_of(60.0, 0.0, {0, 0, 1}).within(pi), 2.0 * pi * (1.0 - std::cos(pi / 6.0)), 1e-14);
    // With one over all of it: the integral of smoothstep by 10^5 midpoints.
    const SpotCone soft = cone_of(60.0, 60.0, {0, 0, 1});
    double sum = 0.0;
    const int count = 100000;
    for (int k = 0; k < count; ++k) {
        const double t = (k + 0.5) / count * pi / 6.0, x = 1.0 - t / (pi / 6.0);
        sum += x * x * (3.0 - 2.0 * x) * std::sin(t) * pi / 6.0 / count;
    }
    EXPECT_NEAR(soft.within(pi) / sum, 1.0, 1e-9);
}

TEST(SpotPatch, WhatMayBeLitHoldsAllThatIs) {
    // The pyramid cuts nothing off that the cone lights, and of a narrow one leaves little else.
    for (const auto& [angle, penumbra] : cones) {
        const SpotCone cone = cone_of(angle, penumbra, {0.2, -0.1, -1});
        std::vector<Triangle> lit;
        double all = 0.0, area = 0.0;
        for (const Triangle& t : shapes::cube_inside(3, 0.5, 0.0).triangles) {
            append_lit(light, cone, t, lit);
            all += spot_power(light, cone, t);
        }
        double kept = 0.0;
        for (const Triangle& t : lit) kept += spot_power(light, cone, t), area += area_of(t);
        EXPECT_NEAR(kept / all, 1.0, 1e-7) << angle;
        // The cone's section with the floor is about a disk of radius .62 tan; a pyramid of 16 sides has 1.3 % more,
        // and the axis leans by 13 degrees: 1 / cos^3.
        if (angle < 10.0) {
            const double radius = 0.62 * std::tan(cone.outer());
            EXPECT_LT(area, 1.2 * pi * radius * radius);
        }
    }
}

TEST(Direct, NoPatchLosesANarrowSpot) {
    // Wherever it falls on a floor of coarse patches, all of its power arrives; and none where a lid is in its way.
    Surfels floor, lid;
    shapes::add_rectangle(floor, {}, {1, 0, 0}, {0, 1, 0}, 4, 4);
    shapes::add_rectangle(lid, {0, 0, 0.3}, {1, 0, 0}, {0, 1, 0}, 1, 1);
    shapes::finish(floor, 0.5, 0.0);
    shapes::finish(lid, 0.5, 0.0);
    for (const Vec3& axis : {Vec3{0, 0, -1}, Vec3{0.07, -0.06, -0.62}, Vec3{0.3, 0.2, -0.62}, Vec3{-0.3, -0.2, -0.62}})
        for (const double angle : {0.1, 1.0, 3.0}) {
            const SpotLight spot{light, normalized(axis), {1, 1, 1}, angle, 0.5 * angle};
            const auto power = [&](const Scene& scene) {
                const std::vector<Rgb> direct = direct_irradiance(scene, Tracer(scene), SurfelPoints(scene.surfels),
                                                                  places_of(scene.surfels), {}, 0);
                double sum = 0.0;
                for (std::uint32_t i = 0; i < 16; ++i) sum += scene.surfels.areas[i] * direct[i].x;
                return sum;
            };
            EXPECT_NEAR(power(shapes::scene_of({floor}, {spot})) / (2.0 * pi * SpotCone(spot).within(pi)), 1.0, 1e-7);
            EXPECT_EQ(power(shapes::scene_of({floor, lid}, {spot})), 0.0);
        }
}

}  // namespace
}  // namespace surflux
