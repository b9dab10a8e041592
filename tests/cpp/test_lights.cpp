#include <gtest/gtest.h>

#include "shapes.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/direct.h"
#include "surflux/lights/emitter.h"
#include "surflux/lights/environment.h"
#include "surflux/lights/hemisphere.h"
#include "surflux/lights/polygon.h"
#include "surflux/lights/spherical_triangle.h"

namespace surflux {
namespace {

using shapes::disk;
using shapes::scene_of;

const Vec3 up{0, 0, 1}, down{0, 0, -1};
const Rgb white{1, 1, 1};

// Irradiance of the scene's first surfel from its lights.
double first_direct(const Scene& scene) {
    const Tracer tracer(scene);
    return direct_irradiance(scene, tracer, SurfelPoints(scene.surfels), places_of(scene.surfels), {}, 0)[0].x;
}

TEST(Polygon, MatchesTabulatedFactors) {
    // Element to unit square: parallel at distance 1 below a corner, perpendicular on an edge's end (Howell B-3, B-4).
    const Vec3 above[4] = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    EXPECT_NEAR(element_to_polygon({}, up, above, 4), 0.1385316060, 1e-10);
    const Vec3 wall[4] = {{1, 0, 0}, {1, 1, 0}, {1, 1, 1}, {1, 0, 1}};
    EXPECT_NEAR(element_to_polygon({}, up, wall, 4), 0.0557341970, 1e-10);
}

TEST(Polygon, CountsOnlyWhatIsAboveTheHorizon) {
    const Vec3 upper[4] = {{1, -1, 0}, {1, 1, 0}, {1, 1, 1}, {1, -1, 1}};
    const Vec3 both[4] = {{1, -1, -5}, {1, 1, -5}, {1, 1, 1}, {1, -1, 1}};
    EXPECT_NEAR(element_to_polygon({}, up, both, 4), element_to_polygon({}, up, upper, 4), 1e-12);
    const Vec3 below[3] = {{1, -1, -5}, {1, 1, -5}, {1, 1, -1}};
    EXPECT_EQ(element_to_polygon({}, up, below, 3), 0.0);
    const Vec3 around[4] = {{-1e6, -1e6, 1}, {1e6, -1e6, 1}, {1e6, 1e6, 1}, {-1e6, 1e6, 1}};
    EXPECT_NEAR(element_to_polygon({}, up, around, 4), 1.0, 1e-5);
    const Vec3 coplanar[4] = {{1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}};
    EXPECT_NEAR(element_to_polygon({}, up, coplanar, 4), 0.0, 1e-12);
}

// What lights are behind they send nothing to; of surfels that face away from a light by far it is so said.
TEST(NormalCone, HasNoLightFromBehind) {
    std::vector<Light> lights{PointLight{{0.3, 0.2, 0.9}, white},
                              DirectionalLight{normalized(Vec3{0.3, 0.1, -1.0}), white},
                              AreaLight{{-0.5, 0.1, 0.8}, {0.4, 0.2, 0.3}, {-0.1, 0.5, 0.1}, white},
                              SpotLight{{0.3, 0.2, 0.9}, {0, 0, -1}, white, 60.0, 5.0}};
    Random random(7, 0);
    const auto vector = [&](double size) {
        return size * Vec3{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
    };
    int behind = 0;
    for (int k = 0; k < 4000; ++k) {
        std::vector<Vec3> places, normals;
        NormalCone cone{vector(4.0), {}};
        const Vec3 axis = normalized(vector(1.0));
        for (int j = 0; j < 5; ++j) {
            places.push_back(cone.center + vector(0.4));
            normals.push_back(normalized(axis + vector(0.6)));
            cone.axis += normals.back() / 5.0;
        }
        for (std::size_t j = 0; j < 5; ++j) {
            cone.spread = std::max(cone.spread, length(normals[j] - cone.axis));
            cone.height = std::max(cone.height, dot(normals[j], cone.center - places[j]));
        }
        for (const auto& light : emitters_of(lights)) {
            double kernels[5];
            light->kernels_at(places.data(), normals.data(), 5, kernels);
            for (std::size_t j = 0; j < 5; ++j) EXPECT_EQ(kernels[j], light->kernel_at(places[j], normals[j])) << k;
            if (!light->is_behind(cone)) continue;
            ++behind;
            for (std::size_t j = 0; j < 5; ++j) EXPECT_EQ(light->kernel_at(places[j], normals[j]), 0.0) << k;
        }
    }
    EXPECT_GT(behind, 4000);  // of 16 000, of which half face away
}

// cos cos' A / (pi r^2) and cos' A / r^2 are right to (size / r)^2. Products of corners cancel: from 5e7 on they were
// off by a per cent, and a sun given in metres was a million times too bright.
TEST(Polygon, FarOnesKeepTheirDigits) {
    const Vec3 towards = normalized(Vec3{0.3, -0.5, 0.7}), normal = normalized(Vec3{0.1, 0.2, 1.0});
    for (double r : {1e2, 1e3, 3e3, 1e4, 1e6, 1e8, 1.5e11}) {
        const Vec3 eye = -r * towards;
        const Vec3 corners[4] = {{0, 0, 0}, {0.2, 0, 0}, {0.2, 0.2, 0}, {0, 0.2, 0}};
        const double solid = towards.z * 0.04 / (r * r), factor = dot(normal, towards) * solid / pi;
        EXPECT_NEAR(element_to_polygon(eye, normal, corners, 4) / factor, 1.0, 1.0 / r + 2e-9 + 1e-15 * r);
        const double found = solid_angle(eye, {corners[0], corners[1], corners[2], 0}) +
                             solid_angle(eye, {corners[0], corners[2], corners[3], 0});
        EXPECT_NEAR(found / solid, 1.0, 1.0 / r + 1e-12) << r;
    }
}

TEST(SphericalTriangle, TheSquareCoversItEvenly) {
    const Vec3 a = normalized(Vec3{1, 0.1, 0.2}), b = normalized(Vec3{-0.2, 1, 0.3}), c = normalized(Vec3{0.1, 0.4, 1});
    const Vec3 corners[3] = {a, b, c}, normal = normalized(Vec3{1, 1, 1});
    constexpr int n = 200;
    double cosine = 0.0;
    for (int i = 0; i < n * n; ++i) {
        const Vec3 d = square_to_spherical_triangle(a, b, c, (i % n + 0.5) / n, (i / n + 0.5) / n);
        EXPECT_NEAR(length(d), 1.0, 1e-12);
        for (int k = 0; k < 3; ++k) EXPECT_GT(dot(d, cross(corners[k], corners[(k + 1) % 3])), -1e-12);
        cosine += dot(d, normal) / (n * n);
    }
    const double solid = solid_angle({}, {a, b, c, 0});
    EXPECT_NEAR(cosine * solid / pi, element_to_polygon({}, normal, corners, 3), 1e-5);
}

// A lamp 40 times as wide as it is far away: points of its area had ten times as much noise as there is light.
TEST(Emitter, WideLightsAreSampledByWhatTheyBring) {
    const std::vector<Light> lights{AreaLight{{-20, -20, 1}, {0, 40, 0}, {40, 0, 0}, white}};
    const auto emitters = emitters_of(lights);
    for (const Vec3& at : {Vec3{}, Vec3{3, -2, 0.9}, Vec3{19.9, 0, 0}, Vec3{21, 21, 0.5}}) {
        const Vec3 normal = normalized(Vec3{0.2, 0.1, 1.0});
        ASSERT_TRUE(emitters[0]->is_wide_at(at));
        EvenPoints even(2, 0, 0);
        double sum = 0.0;
        constexpr int n = 4096;
        for (int k = 0; k < n; ++k) {
            const double* u = even.next();
            const Arrival arrival = emitters[0]->arrival(at, normal, u[0], u[1]);
            EXPECT_NEAR(arrival.from.z, 1.0, 1e-9);
            EXPECT_LE(std::max(std::abs(arrival.from.x), std::abs(arrival.from.y)), 20.0 + 1e-6);
            sum += arrival.kernel / n;
        }
        EXPECT_NEAR(sum / emitters[0]->kernel_at(at, normal), 1.0, 2e-3) << at.x;
    }
}

TEST(Direct, PointLightFollowsTheInverseSquareAndTheCosine) {
    const PointLight light{{3, 0, 4}, {50, 50, 50}};
    // r = 5, cos = 4/5: I cos / r^2.
    EXPECT_NEAR(first_direct(scene_of({disk({}, up, 0.1)}, {light})), 50 * 0.8 / 25, 1e-12);
    EXPECT_EQ(first_direct(scene_of({disk({}, down, 0.1)}, {light})), 0.0);
    EXPECT_EQ(first_direct(scene_of({disk({}, up, 0.1), disk({1.5, 0, 2}, up, 0.2)}, {light})), 0.0);
}

TEST(Direct, SpotLightFadesBySmoothstepInAngle) {
    const auto at_angle = [](double degrees) {
        const double x = std::tan(degrees * pi / 180.0);
        const Scene scene = scene_of({disk({x, 0, 0}, up, 0.01)}, {SpotLight{{0, 0, 1}, down, white, 60.0, 20.0}});
        const double cosine = 1.0 / std::sqrt(1.0 + x * x);
        return first_direct(scene) / (cosine * cosine * cosine);  // I cos / r^2, r = 1 / cos
    };
    // Half angles: full to 20 degrees, out at 30; midway smoothstep(1/2) = 1/2, and smoothstep(1/4) = 5/32.
    EXPECT_NEAR(at_angle(19.9), 1.0, 1e-9);
    EXPECT_NEAR(at_angle(25.0), 0.5, 1e-9);
    EXPECT_NEAR(at_angle(27.5), 5.0 / 32.0, 1e-9);
    EXPECT_EQ(at_angle(30.1), 0.0);
}

TEST(Direct, AreaLightIsTheClosedFormWhereNothingBlocks) {
    // A unit square, exitance 2, one above the surfel, that emits down.
    const AreaLight light{{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {2, 2, 2}};
    EXPECT_NEAR(first_direct(scene_of({disk({}, up, 0.1)}, {light})), 2 * 0.1385316060, 1e-9);
    const AreaLight away{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {2, 2, 2}};
    EXPECT_EQ(first_direct(scene_of({disk({}, up, 0.1)}, {away})), 0.0);
}

TEST(Direct, AreaLightBehindAnEdgeIsHalfVisible) {
    // A wall over the half plane y > 0 hides the half y > 0 of a lamp that is symmetric about y = 0, seen from y = 0.
    Surfels wall;
    shapes::add_rectangle(wall, {-5, 0, 0.5}, {10, 0, 0}, {0, 5, 0}, 1, 1);
    shapes::finish(wall, 0.5, 0.0);
    const AreaLight light{{-0.5, -0.5, 1}, {0, 1, 0}, {1, 0, 0}, white};
    const double open = first_direct(scene_of({disk({}, up, 0.01)}, {light}));
    // 64 evenly spread rays: the share is off by a few in 64.
    EXPECT_NEAR(first_direct(scene_of({disk({}, up, 0.01), wall}, {light})) / open, 0.5, 4.0 / 64.0);
}

TEST(Direct, PatchesAverageOverTheirArea) {
    // A patch of which half lies in shadow of a directional light gets half.
    Surfels floor, lid;
    shapes::add_rectangle(floor, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1, 1);
    shapes::add_rectangle(lid, {0, 0, 1}, {0.5, 0, 0}, {0, 1, 0}, 1, 1);
    shapes::finish(floor, 0.5, 0.0);
    shapes::finish(lid, 0.5, 0.0);
    const DirectionalLight sun{down, {3, 3, 3}};
    EXPECT_NEAR(first_direct(scene_of({floor, lid}, {sun})), 1.5, 3.0 * 4.0 / 64.0);
    EXPECT_NEAR(first_direct(scene_of({floor}, {sun})), 3.0, 1e-12);
}

Environment image_of(std::size_t width, std::size_t height, const Vec3& axis_up) {
    Environment e;
    e.width = width;
    e.height = height;
    e.up = axis_up;
    for (std::size_t k = 0; k < width * height; ++k) {
        const double v = 0.1 + static_cast<double>((k * 7919) % 101) / 10.0;
        e.pixels.push_back({v, 0.5 * v, 2.0 * v});
    }
    return e;
}

TEST(Direct, PartsOfAPatchShareItsRays) {
    // The only patch of its size has 256 times the rays of the options; a 256th of it those of the options. Their
    // number shows in the standard error of a part that is half in shade.
    Surfels floor, parts, lid;
    shapes::add_rectangle(floor, {}, {1, 0, 0}, {0, 1, 0}, 1, 1);
    shapes::add_rectangle(parts, {}, {1, 0, 0}, {0, 1, 0}, 16, 16);
    shapes::add_rectangle(lid, {-5, -5, 0.5}, {5.45, 0, 0}, {0, 10, 0}, 1, 1);
    for (Surfels* s : {&floor, &parts, &lid}) shapes::finish(*s, 0.5, 0.0);
    const PointLight light{{0.5, 0.5, 1}, white};
    const std::uint32_t half_in_shade = 6 * 16 + 8;
    const Place place{parts.positions[half_in_shade], up, 0, half_in_shade, true};
    const auto shine = [&](const Scene& scene, std::vector<Rgb>& errors) {
        const Tracer tracer(scene);
        return direct_irradiance(scene, tracer, SurfelPoints(parts), {place}, {16, 64}, 0, {}, &errors)[0].x;
    };
    std::vector<Rgb> none, errors;
    const double all = shine(scene_of({floor}, {light}), none), lit = shine(scene_of({floor, lid}, {light}), errors);
    EXPECT_EQ(none[0].x, 0.0);
    EXPECT_NEAR(lit / all, 0.6, 0.1);
    // Of even points it is half that of random ones.
    EXPECT_NEAR(errors[0].x / (0.5 * std::sqrt(lit * (all - lit) / 64)), 1.0, 0.01);
}

// The kernel at a place is the mean of what points of the light bring there.
TEST(Emitter, TheKernelIsTheMeanOverTheLight) {
    const std::vector<Light> lights{PointLight{{0.3, 0.2, 1.5}, white},
                                    SpotLight{{0.3, 0.2, 1.5}, normalized({-0.2, 0, -1}), white, 50.0, 30.0},
                                    DirectionalLight{normalized({0.2, -0.3, -1}), white},
                                    AreaLight{{-0.4, 0.1, 0.9}, {0, 0.8, 0.2}, {0.7, 0, 0}, white}};
    for (const std::unique_ptr<Emitter>& light : emitters_of(lights)) {
        for (const Vec3& normal : {up, normalized({0.5, 0.4, 0.6}), down}) {
            constexpr int n = 400;  // a midpoint rule: its error goes with 1 / n^2, but where the horizon cuts it
            double sum = 0.0;
            for (int a = 0; a < n; ++a)
                for (int b = 0; b < n; ++b) sum += light->arrival({}, normal, (a + 0.5) / n, (b + 0.5) / n).kernel;
            EXPECT_NEAR(light->kernel_at({}, normal), sum / (n * n), 1e-5);
        }
    }
}

TEST(EnvironmentMap, SamplesInProportionToTheDensityItStates) {
    const Environment e = image_of(8, 4, normalized({1, 2, 3}));
    const EnvironmentMap map(e);
    // If directions have density p, the mean of 1/p is the sphere, 4 pi, and that of radiance/p the integral of
    // radiance.
    EvenPoints even(2, 0, 0);
    double sphere = 0.0, light = 0.0, expected = 0.0;
    const int n = 20000;
    for (int k = 0; k < n; ++k) {
        const double* u = even.next();
        const Vec3 d = map.sample(u[0], u[1]);
        ASSERT_NEAR(length(d), 1.0, 1e-12);
        sphere += 1.0 / map.density(d) / n;
        light += map.radiance(d).x / map.density(d) / n;
    }
    for (std::size_t row = 0; row < 4; ++row)
        for (std::size_t col = 0; col < 8; ++col)
            expected += e.pixels[row * 8 + col].x *
                        (std::cos(pi * double(row) / 4) - std::cos(pi * double(row + 1) / 4)) * 2.0 * pi / 8.0;
    EXPECT_NEAR(sphere, 4.0 * pi, 0.02 * 4.0 * pi);
    EXPECT_NEAR(light, expected, 1e-3 * expected);  // radiance / density is nearly constant: hardly any spread
}

TEST(EnvironmentMap, ColumnsTurnAroundUpByTheShortestRotation) {
    Environment e = image_of(4, 2, up);
    // theta = pi/4 for row 0, phi = 3 pi/4 for column 0.
    const Vec3 first = normalized({-1, 1, std::sqrt(2.0)});
    EXPECT_EQ(EnvironmentMap(e).radiance(first), e.pixels[0]);
    EXPECT_EQ(EnvironmentMap(e).radiance({first.x, first.y, -first.z}), e.pixels[4]);
    // On go the columns, clockwise seen from above: right as seen from inside.
    EXPECT_EQ(EnvironmentMap(e).radiance({-first.x, first.y, first.z}), e.pixels[1]);
    EXPECT_EQ(EnvironmentMap(e).radiance({-first.x, -first.y, first.z}), e.pixels[2]);
    e.up = {1, 0, 0};  // the quarter turn around y: z -> x, x -> -z
    EXPECT_EQ(EnvironmentMap(e).radiance({first.z, first.y, -first.x}), e.pixels[0]);
}

TEST(Hemispheres, OfAConvexCloudSeeTheWholeSky) {
    for (std::uint64_t seed : {0u, 1u}) {
        const Scene scene = scene_of({shapes::sphere(300, 1.0, 1.0, 0.5, 0.0)}, {Environment{{2, 2, 2}, 0, 0, {}, up}});
        const Tracer tracer(scene);
        const Hemispheres h = measure_hemispheres(scene, tracer, 64, seed);
        for (std::size_t i = 0; i < scene.surfels.size(); ++i) {
            EXPECT_NEAR(h.escape[i], 1.0, 1e-12);
            EXPECT_EQ(h.absorbed[i], 0.0);
            EXPECT_EQ(h.constant_sky.x, 2.0);
        }
    }
}

TEST(Hemispheres, TellBackFacesFromOpenSky) {
    // Below the back of a very large square: all that is not escape is absorbed, and F = .5 to a disk of r = h on axis.
    const Scene scene = scene_of({disk({}, up, 0.01), disk({0, 0, 1}, up, 1.0)});
    const Tracer tracer(scene);
    const Hemispheres h = measure_hemispheres(scene, tracer, 4096, 0);
    EXPECT_NEAR(h.absorbed[0], 0.5, 0.01);
    EXPECT_NEAR(h.absorbed[0] + h.escape[0], 1.0, 1e-9);
}

}  // namespace
}  // namespace surflux
