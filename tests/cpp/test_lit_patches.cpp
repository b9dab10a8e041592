#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "shapes.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/lit_patches.h"
#include "surflux/meshless/hemisphere_gather.h"

namespace surflux {
namespace {

// A box whose patches send more the farther they are along x, and a ball of disks.
struct Lit {
    explicit Lit(const Vec3& offset = {}, double scale = 1.0) {
        scene = shapes::scene_of(
            {shapes::cube_inside(6, 0.5, 0.0), shapes::sphere(100, 0.2, 1.0, 0.5, 0.0, {0.7, 0.5, 0.5})});
        Surfels& s = scene.surfels;
        for (Vec3& p : s.positions) p = offset + scale * p;
        for (Triangle& t : s.triangles)
            for (Vec3* corner : {&t.a, &t.b, &t.c}) *corner = offset + scale * *corner;
        for (double& r : s.radii) r *= scale;
        for (double& a : s.areas) a *= scale * scale;
        for (const Vec3& p : s.positions) exitance.push_back(std::max(0.0, (p.x - offset.x) / scale - 0.4));
        points = std::make_unique<SurfelPoints>(s);
        patches = std::make_unique<LitPatches>(s, *points, exitance);
    }
    Scene scene;
    std::vector<double> exitance;
    std::unique_ptr<SurfelPoints> points;
    std::unique_ptr<LitPatches> patches;
};

TEST(LitPatches, AreDrawnWithTheDensityThatIsSaid) {
    const Lit lit;
    const Surfels& s = lit.scene.surfels;
    LitPatches::Aim aim;
    ASSERT_TRUE(lit.patches->aim({0.3, 0.0, 0.5}, {0, 1, 0}, aim));
    double sum = 0.0, by_disks = 0.0, by_all = 0.0;
    std::vector<double> expected(s.size());
    for (std::uint32_t i = 0; i < s.size(); ++i) {
        sum += expected[i] = s.areas[i] * lit.patches->density(aim, i);
        by_all += s.areas[i] * lit.exitance[i];
        if (lit.points->is_patch(i)) continue;
        EXPECT_EQ(expected[i], 0.0);
        by_disks += s.areas[i] * lit.exitance[i];
    }
    EXPECT_NEAR(sum, 1.0, 1e-5);
    ASSERT_GT(by_disks, 0.0);
    EXPECT_NEAR(lit.patches->share(), 1.0 - by_disks / by_all, 1e-12);
    const int n = 400000;
    std::vector<int> drawn(s.size(), 0);
    std::vector<Vec3> mean(s.size());
    Random random(1, 2);
    for (int k = 0; k < n; ++k) {
        const double u = random.uniform(), v = random.uniform();
        const LitPatches::Target to = lit.patches->sample(aim, (k + random.uniform()) / n, u, v);
        ++drawn[to.surfel];
        mean[to.surfel] += to.point;
    }
    for (std::uint32_t i = 0; i < s.size(); ++i) {
        if (!(lit.exitance[i] > 0.0)) {
            ASSERT_EQ(drawn[i], 0) << i;
        }
        ASSERT_NEAR(drawn[i], n * expected[i], 5.0 * std::sqrt(n * expected[i]) + 2.0) << i;
        if (drawn[i] > 100) {
            ASSERT_LT(length(mean[i] / drawn[i] - s.positions[i]), 5.0 * s.radii[i] / std::sqrt(drawn[i]));
        }
    }
}

TEST(LitPatches, AreTheSameInAnyUnitAndFarAway) {
    const Lit near, far({3e6, -2e6, 1e5}), tiny({}, 1e-9), huge({}, 1e12);
    const auto density = [](const Lit& lit, const Vec3& offset, double scale, std::uint32_t i) {
        LitPatches::Aim aim;
        EXPECT_TRUE(lit.patches->aim(offset + scale * Vec3{0.3, 0.1, 0.5}, {0, 1, 0}, aim));
        return scale * scale * lit.patches->density(aim, i);
    };
    for (const std::uint32_t i : {50u, 110u, 130u, 200u}) {
        const double d = density(near, {}, 1.0, i);
        EXPECT_NEAR(density(far, {3e6, -2e6, 1e5}, 1.0, i), d, 1e-4 * d + 1e-9);
        EXPECT_NEAR(density(tiny, {}, 1e-9, i), d, 1e-4 * d + 1e-9);
        EXPECT_NEAR(density(huge, {}, 1e12, i), d, 1e-4 * d + 1e-9);
    }
}

TEST(LitPatches, ThereIsNothingToAimAtBehindAndInTheDark) {
    Surfels floor;
    shapes::add_rectangle(floor, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 4, 4);
    shapes::finish(floor, 0.5, 0.0);
    const SurfelPoints points(floor);
    const LitPatches lit(floor, points, std::vector<double>(floor.size(), 1.0)),
        dark(floor, points, std::vector<double>(floor.size(), 0.0));
    LitPatches::Aim aim;
    EXPECT_TRUE(lit.aim({0.5, 0.5, 3}, {0, 0, -1}, aim));
    EXPECT_FALSE(lit.aim({0.5, 0.5, 3}, {0, 0, 1}, aim));
    EXPECT_FALSE(lit.aim({0.5, 0.5, -3}, {0, 0, 1}, aim));
    EXPECT_EQ(dark.share(), 0.0);
    EXPECT_FALSE(dark.aim({0.5, 0.5, 3}, {0, 0, -1}, aim));
}

// Share of the hemisphere of an element that a rectangle a by b, at distance 1 and parallel, over the element with one
// corner, covers (Howell B-3).
double corner_factor(double a, double b) {
    const double x = std::sqrt(1.0 + a * a), y = std::sqrt(1.0 + b * b);
    return (a / x * std::atan(b / x) + b / y * std::atan(a / y)) / (2.0 * pi);
}

struct Spot {
    double blocked = 0.0;  // of it, by a plate half way
    bool lights_in_basis = false;
    std::uint64_t seed = 0;
    double areas = 1.0;  // over the true ones
    // Turned, made smaller and put aside, with something small as far on the other side.
    double scale = 1.0;
    Vec3 offset{};
};

// What one place below a lit spot of 0.1 by 0.1 gathers of it, as a share of what the spot sends; all else is black.
double gathered(const Spot& of) {
    const bool aside = length(of.offset) > 0.0;
    const Frame frame = aside ? frame_around(normalized(Vec3{0.3, 0.5, 0.8})) : Frame{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const auto to = [&](const Vec3& p) { return of.offset + of.scale * frame.to_world(p); };
    Scene scene;
    const auto add = [&](const Vec3& corner, const Vec3& u, const Vec3& v, int parts, double rho) {
        Surfels s;
        shapes::add_rectangle(s, to(corner), of.scale * frame.to_world(u), of.scale * frame.to_world(v), parts, parts);
        shapes::finish(s, rho, 0.0);
        for (double& area : s.areas) area *= of.areas;
        append(scene, s);
    };
    add({-0.05, -0.05, 1}, {0, 0.1, 0}, {0.1, 0, 0}, 3, 0.5);
    const auto under = static_cast<std::uint32_t>(scene.surfels.size());
    add({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 1, 0.0);
    if (of.blocked > 0.0) add({-0.025, -0.025, 0.5}, {0, 0.05, 0}, {0.05 * of.blocked, 0, 0}, 1, 0.0);
    if (aside) {
        Surfels far = shapes::disk(-of.offset, {0, 0, 1}, 1.0);
        shapes::finish(far, 0.0, 0.0);
        append(scene, far);
    }
    scene.lights = {DirectionalLight{frame.to_world(normalized(Vec3{1, 0, 0.2})), {8, 8, 8}}};
    const Tracer tracer(scene);
    const SurfaceLight light(scene, tracer, {}, of.lights_in_basis, 256, {}, of.seed, {});
    const MultilevelBasis basis;
    const BasisSight sight(scene, tracer, basis);
    const SurfelMeans means(scene, tracer, light.points(), basis, sight, {1.0, 1.0, 1.0, 1.0}, {1, 1.0, of.seed}, {});
    HemisphereGather gather(scene, tracer, light, basis, means, {0.314, of.seed});
    const Place place{to({0, 0, 0}), frame.n, under, Place::point};
    const auto found = gather.once({place}, {256}, {}, std::vector<Rgb>(scene.surfels.size()), {});
    return found[0].row.first_bounce.x / (scene.surfels.reflectance[0] * light.direct_at_surfel(0)).x;
}

// Of 256 rays over the hemisphere, about one would meet it.
TEST(HemisphereGather, FindsASpotOfSunByAimedRays) {
    const double all = 4.0 * corner_factor(0.05, 0.05);
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
        EXPECT_NEAR(gathered({0.0, false, seed}), all, 0.02 * all);
        EXPECT_NEAR(gathered({0.5, false, seed}), 0.5 * all, 0.15 * all);
        EXPECT_EQ(gathered({1.0, false, seed}), 0.0);
        EXPECT_EQ(gathered({0.0, true, seed}), 0.0);  // it is the basis that sends
        EXPECT_NEAR(gathered({0.0, false, seed, 3.0}), all, 0.02 * all);
        EXPECT_NEAR(gathered({0.0, false, seed, 1.0, 0.1, {700, -500, 200}}), all, 0.03 * all);
        EXPECT_NEAR(gathered({0.0, false, seed, 1.0, 1.0, {5000, -3000, 2000}}), all, 0.03 * all);
    }
    double sum = 0.0;
    for (std::uint64_t seed = 0; seed < 100; ++seed) sum += gathered({0.5, false, seed}) / 100;
    EXPECT_NEAR(sum, 0.5 * all, 0.02 * all);
}

}  // namespace
}  // namespace surflux
