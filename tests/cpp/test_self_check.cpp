#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "shapes.h"
#include "surflux/core/random.h"
#include "surflux/lights/polygon.h"
#include "surflux/solution/self_check.h"

namespace surflux {
namespace {

Solution solution_of(const Scene& scene, const std::vector<Rgb>& irradiance) {
    Solution out;
    out.surfels = scene.surfels;
    out.irradiance = out.radiosity = irradiance;
    out.direct.resize(irradiance.size());
    out.parents.resize(irradiance.size());
    std::iota(out.parents.begin(), out.parents.end(), 0u);
    return out;
}

double error_of(const Scene& scene, double irradiance) {
    const std::vector<Rgb> all(scene.surfels.size(), Rgb{1, 1, 1} * irradiance);
    SelfCheckOptions options;
    options.surfels = 200;
    return gathering_error(scene, Tracer(scene), solution_of(scene, all), options).estimate.error;
}

// A room whose walls emit E and reflect rho: H = E / (1 - rho) everywhere. One bounce of what is off by a share s
// brings back rho s: a check that looks two bounces deep would see (1 - rho^2) s.
TEST(SelfCheck, SeesAllBounces) {
    for (const double rho : {0.5, 0.9, 0.99}) {
        const Scene scene = shapes::scene_of({shapes::cube_inside(4, rho, 1.0)});
        const double exact = 1.0 / (1.0 - rho);
        EXPECT_LT(error_of(scene, exact), 1e-9) << rho;
        // Not to all digits: the halves have different places, of whose rays other shares arrive near by.
        for (const double off : {0.8, 1.1}) EXPECT_NEAR(error_of(scene, off * exact) / std::abs(1.0 - off), 1.0, 1e-3);
    }
}

// The same within a larger room, which sees the backs of its walls alone, as a floor beneath a box sees that: what of
// the error a region has by area its hidden half does not have, and rays do not find it. Where light has leaked there,
// it is wrong there alone.
TEST(SelfCheck, SeesAllBouncesBesideHiddenSurfels) {
    const std::size_t walls = 6 * 4 * 4;
    for (const double rho : {0.5, 0.99}) {
        Scene scene = shapes::scene_of({shapes::cube_inside(4, rho, 1.0), shapes::cube_inside(4, rho, 0.0)});
        const auto widen = [](Vec3& p) { p = 1.01 * p - Vec3{0.005, 0.005, 0.005}; };
        for (std::size_t i = walls; i < 2 * walls; ++i) widen(scene.surfels.positions[i]);
        for (Triangle& t : scene.surfels.triangles)
            if (t.surfel >= walls) widen(t.a), widen(t.b), widen(t.c);
        const double exact = 1.0 / (1.0 - rho);
        for (const double leaked : {0.0, 0.03}) {
            std::vector<Rgb> irradiance(2 * walls, Rgb{1, 1, 1} * (1.05 * exact));
            for (std::size_t i = walls; i < 2 * walls; ++i) irradiance[i] = Rgb{1, 1, 1} * (leaked * exact);
            const double truth = std::hypot(0.05, leaked);
            for (const std::uint64_t seed : {0, 1, 2}) {
                SelfCheckOptions options;
                options.seed = seed;
                const double error =
                    gathering_error(scene, Tracer(scene), solution_of(scene, irradiance), options).estimate.error;
                EXPECT_NEAR(error / truth, 1.0, 0.1) << rho << " " << leaked << " " << seed;
            }
        }
    }
}

// A lamp in the middle of a black ball of radius 2: H = I / 4, all of it direct.
TEST(SelfCheck, SeesDirectLight) {
    const Scene scene =
        shapes::scene_of({shapes::sphere(2000, 2.0, -1.0, 0.0, 0.0)}, {PointLight{{0, 0, 0}, {4, 4, 4}}});
    EXPECT_LT(error_of(scene, 1.0), 1e-9);
    EXPECT_NEAR(error_of(scene, 1.1), 0.1, 1e-6);
    EXPECT_NEAR(error_of(scene, 0.9), 0.1, 1e-6);
}

// A lamp off the centre of a ball of radius 2, which reflects .99: all of it receives as much from each surfel, so that
// H = D + rho I / R^2 / (1 - rho). Errors of 1 % at surfels, of mean 0, have a mean of .03 % over 1000 of them: as a
// mean residual, the hundred bounces would make 3 % of it.
TEST(SelfCheck, MeanErrorOfAClosedRoomIsNoChance) {
    const double rho = 0.99, radius = 2.0;
    const Vec3 lamp{0.8, 0.3, 0.4};
    const Scene scene = shapes::scene_of({shapes::sphere(2000, radius, -1.0, rho, 0.0)}, {PointLight{lamp, {4, 4, 4}}});
    Solution solution = solution_of(scene, std::vector<Rgb>(scene.surfels.size()));
    Random random(7, 0);
    double off = 0.0, all = 0.0;
    for (std::size_t i = 0; i < scene.surfels.size(); ++i) {
        const Vec3 d = lamp - scene.surfels.positions[i];
        const double distance = length(d);
        const double direct = 4.0 * dot(d, scene.surfels.normals[i]) / (distance * distance * distance);
        const double exact = direct + rho * 4.0 / (radius * radius) / (1.0 - rho);
        const double error = 0.02 * (random.uniform() - 0.5) * std::sqrt(3.0) * exact;
        solution.direct[i] = Rgb{direct, direct, direct};
        solution.irradiance[i] = Rgb{1, 1, 1} * (exact + error);
        off += error * error, all += exact * exact;
    }
    const double truth = std::sqrt(off / all);
    for (const std::uint64_t seed : {0, 1, 2}) {
        SelfCheckOptions options;
        options.seed = seed;
        const double error = gathering_error(scene, Tracer(scene), solution, options).estimate.error;
        EXPECT_GT(error, 0.7 * truth) << seed;
        EXPECT_LT(error, 1.5 * truth) << seed;
    }
}

// Of an area light within a ball that nothing blocks its samples tell nothing that Lambert's formula does not: no noise
// of theirs is an error. Points of which each is its centre, so that there is no mean over places either.
TEST(SelfCheck, UnblockedLampHasNoNoise) {
    const AreaLight lamp{{-0.2, -0.2, 0.1}, {0, 0.4, 0}, {0.4, 0, 0}, {30, 30, 30}};
    const Vec3 corners[] = {{-0.2, -0.2, 0.1}, {-0.2, 0.2, 0.1}, {0.2, 0.2, 0.1}, {0.2, -0.2, 0.1}};
    const Scene scene = shapes::scene_of({shapes::sphere(500, 1.0, -1.0, 0.0, 0.0)}, {lamp});
    Solution solution = solution_of(scene, std::vector<Rgb>(scene.surfels.size()));
    const Surfels& s = scene.surfels;
    for (const double off : {0.0, 1e-3}) {
        for (std::size_t i = 0; i < s.size(); ++i)
            if (s.positions[i].z < 0.1)  // it shines down
                solution.irradiance[i] = solution.direct[i] =
                    (1.0 + off) * element_to_polygon(s.positions[i], s.normals[i], corners, 4) * lamp.exitance;
        const double error = gathering_error(scene, Tracer(scene), solution, {}).estimate.error;
        EXPECT_NEAR(error, off, 1e-6);
    }
}

// Four patches of a floor, and black walls that stand on it: what a lamp low above one of them sends to it is its solid
// angle, of which nearly all lies within a few heights of the lamp.
struct LowLamp {
    static constexpr double width = 0.2;
    Vec3 place;
    // The part of the patch up to x = `end`.
    double solid_angle_to(double left, double front, double end) const {
        if (!(end > left)) return 0.0;
        const Vec3 a{left, front, 0}, b{end, front, 0}, c{end, front + width, 0}, d{left, front + width, 0};
        return solid_angle(place, {a, b, c, 0}) + solid_angle(place, {a, c, d, 0});
    }
};

double error_under(const LowLamp& lamp, const Light& light, bool has_wall, double factor, std::uint64_t seed) {
    constexpr double width = LowLamp::width;
    Surfels floor;
    shapes::add_rectangle(floor, {0, 0, 0}, {2 * width, 0, 0}, {0, 2 * width, 0}, 2, 2);
    shapes::finish(floor, 0.0, 0.0);
    const std::size_t patches = floor.size();
    const double end = has_wall ? lamp.place.x + 0.01 : 2 * width;
    Scene scene = shapes::scene_of({floor}, {light});
    if (has_wall) {  // it faces away from the lamp, and so has no light
        Surfels wall;
        shapes::add_rectangle(wall, {end, -1, 0}, {0, 3, 0}, {0, 0, 3}, 1, 1);
        shapes::finish(wall, 0.0, 0.0);
        append(scene, wall);
    }
    Solution solution = solution_of(scene, std::vector<Rgb>(scene.surfels.size()));
    for (std::size_t i = 0; i < patches; ++i) {
        const Vec3& at = scene.surfels.positions[i];
        const double left = at.x - 0.5 * width, front = at.y - 0.5 * width;
        const double mean = lamp.solid_angle_to(left, front, std::min(left + width, end)) / (width * width);
        solution.irradiance[i] = solution.direct[i] = Rgb{1, 1, 1} * (factor * mean);
    }
    SelfCheckOptions options;
    options.surfels = 400;
    options.seed = seed;
    return gathering_error(scene, Tracer(scene), solution, options).estimate.error;
}

TEST(SelfCheck, LampCloseToAPatchHasNoNoise) {
    for (const double height : {0.01, 0.001}) {
        const LowLamp lamp{{0.13, 0.07, height}};
        const PointLight point{lamp.place, {1, 1, 1}};
        EXPECT_LT(error_under(lamp, point, false, 1.0, 0), 1e-6) << height;
        EXPECT_NEAR(error_under(lamp, point, false, 1.1, 0), 0.1, 1e-6) << height;
        // All of the patches are in the middle of its beam.
        const SpotLight spot{lamp.place, {0, 0, -1}, {1, 1, 1}, 360.0, 0.0};
        EXPECT_LT(error_under(lamp, spot, false, 1.0, 0), 1e-6) << height;
    }
}

// Behind the wall there is none of its light; points evenly over the patch found half of it there.
TEST(SelfCheck, SeesWhatOfACloseLampIsHidden) {
    for (const std::uint64_t seed : {0, 1, 2}) {
        const LowLamp lamp{{0.13, 0.07, 0.005}};
        const PointLight point{lamp.place, {1, 1, 1}};
        EXPECT_LT(error_under(lamp, point, true, 1.0, seed), 0.02) << seed;
        EXPECT_NEAR(error_under(lamp, point, true, 1.1, seed), 0.1, 0.02) << seed;
        EXPECT_NEAR(error_under(lamp, point, true, 0.8, seed), 0.2, 0.03) << seed;
    }
}

// Regions with one place in each half, of which all reflect .99 and have an error of mean 0: the estimate is chance, a
// product of two independent means, which passes three of its standard deviations in one of a hundred cases.
TEST(SelfCheck, KnowsTheChanceOfRegionsWithOnePlace) {
    constexpr std::size_t count = 20, trials = 200;
    Surfels walls = shapes::cube_inside(4, 0.99, 0.0);
    Regions regions(walls, std::vector<Rgb>(walls.size(), Rgb{1, 1, 1}), count);
    std::size_t surprises = 0;
    for (std::size_t trial = 0; trial < trials; ++trial) {
        Random random(7, trial);
        std::vector<Gathered> sums(4 * regions.count, Gathered(regions.count));
        std::vector<Residual> residuals;
        for (std::uint32_t k = 0; k < 2 * regions.count; ++k) {
            const double chance = 0.02 * (random.uniform() - 0.5);
            for (Gathered* half : {&sums[2 * k], &sums[2 * k + 1]}) {
                half->irradiance = half->of_all = Rgb{1, 1, 1} * (1.0 + chance);
                for (std::size_t g = 0; g < regions.count; ++g) {
                    half->met[g] = regions.share[g];
                    half->from[g] = regions.share[g] * regions.reflectance[g];
                }
            }
            residuals.push_back(
                {{1, 1, 1}, {0, 0, 0}, {1, 1, 1}, k / 2, {&sums[2 * k], &sums[2 * k + 1]}, {0.99, 0.99, 0.99}});
        }
        const ErrorEstimate estimate = error_from(residuals, regions, 1.0, {});
        surprises += estimate.error > 6.0 * estimate.uncertainty;
    }
    EXPECT_LT(surprises, trials / 20);
}

// Nothing is sure of what is not a number.
TEST(SelfCheck, ClaimsNothingOfNaN) {
    const Scene scene = shapes::scene_of({shapes::cube_inside(4, 0.5, 1.0)});
    EXPECT_EQ(error_of(scene, std::numeric_limits<double>::quiet_NaN()), 1.0);
    // One surfel, drawn or not: of four tries most do not draw it, nor meet it with all of their rays.
    const Scene ball = shapes::scene_of({shapes::sphere(2000, 2.0, 1.0, 0.5, 1.0)});
    const Tracer tracer(ball);
    for (std::size_t bad = 0; bad < 2000; bad += 500) {
        std::vector<Rgb> irradiance(ball.surfels.size(), Rgb{1, 1, 1});
        irradiance[bad].y = std::numeric_limits<double>::quiet_NaN();
        SelfCheckOptions options;
        options.surfels = 20;
        EXPECT_EQ(gathering_error(ball, tracer, solution_of(ball, irradiance), options).estimate.error, 1.0);
    }
}

}  // namespace
}  // namespace surflux
