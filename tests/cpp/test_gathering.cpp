#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "shapes.h"
#include "surflux/core/parallel.h"
#include "surflux/radiosity/gathering.h"

namespace surflux {
namespace {

using shapes::add_rectangle;
using shapes::cube_inside;
using shapes::finish;
using shapes::scene_of;
using shapes::sphere;

// All that a Gathering refers to.
struct Gathered {
    Scene scene;
    Tracer tracer;
    SurfelTree tree;
    LightSampler skies;
    SurfelPoints points;
    Gathering gathering;

    explicit Gathered(Scene of, std::uint64_t seed = 0)
        : scene(std::move(of)),
          tracer(scene),
          tree(scene, build_hierarchy(scene.surfels, scene.object, {}), scene.surfels.size()),
          skies(scene, LightSampler::usual_small_emitters, LightSampler::Sources::constant_sky),
          points(scene.surfels),
          gathering(points, tracer, tree, skies, seed) {}

    void add_all(int rays) {
        const std::vector<Place> places = places_of(scene.surfels);
        gathering.add(places, std::vector<int>(places.size(), rays));
    }
    // What nodes send where surfels send so much.
    std::vector<double> sent(const std::vector<double>& by_surfel) const {
        std::vector<double> out = by_surfel;
        tree.pull_up(out, 1);
        return out;
    }
    double gathered(std::size_t row, const std::vector<double>& from) const {
        double out = 0.0;
        gathering.gather(row, from, 1, &out);
        return out;
    }
};

Scene open_scene() {
    Surfels floor, roof;
    add_rectangle(floor, {0, 0, 0}, {2, 0, 0}, {0, 2, 0}, 8, 8);
    add_rectangle(roof, {0.5, 0.5, 1}, {0, 1, 0}, {1, 0, 0}, 4, 4);
    finish(floor, 0.5, 0.0);
    finish(roof, 0.5, 0.0);
    const Surfels turned_away = shapes::disk({0.3, 1.6, 0.6}, {0, 0, 1}, 0.15);
    return scene_of({floor, roof, sphere(200, 0.2, 1.0, 0.5, 0.0, {1.6, 1.6, 0.25}), turned_away});
}

TEST(Gathering, ARowWithWhatEscapesAndWhatBacksTakeIsOne) {
    Gathered g(open_scene());
    g.add_all(64);
    const std::vector<double> ones = g.sent(std::vector<double>(g.scene.surfels.size(), 1.0));
    bool escapes = false, absorbs = false;
    for (std::size_t row = 0; row < g.gathering.size(); ++row) {
        const Gathering::Row& r = g.gathering.row(row);
        EXPECT_NEAR(g.gathered(row, ones) + r.escape + r.absorbed, 1.0, 1e-6) << row;
        EXPECT_GE(r.closeness, 0.0f);
        escapes = escapes || r.escape > 0.5f;
        absorbs = absorbs || r.absorbed > 0.0f;
    }
    EXPECT_TRUE(escapes);
    EXPECT_TRUE(absorbs);  // else the sum above says less than it seems
    EXPECT_EQ(g.gathering.rays(), 64 * g.scene.surfels.size());
    EXPECT_LT(g.gathering.links(), g.gathering.rays());
}

TEST(Gathering, AClosedRoomLosesNothing) {
    Gathered g(scene_of({cube_inside(8, 0.5, 0.0)}));
    g.add_all(256);
    const std::vector<double> ones = g.sent(std::vector<double>(g.scene.surfels.size(), 1.0));
    for (std::size_t row = 0; row < g.gathering.size(); ++row) {
        EXPECT_EQ(g.gathering.row(row).escape, 0.0f);
        EXPECT_EQ(g.gathering.row(row).absorbed, 0.0f);
        EXPECT_NEAR(g.gathered(row, ones), 1.0, 1e-12);
    }
}

TEST(Gathering, FacesOfTheCubeGetWhatTheClosedFormSays) {
    // From the floor to the ceiling .1998, to a wall .2000: by whatever groups of them rays meet.
    const int n = 10;
    Gathered g(scene_of({cube_inside(n, 0.5, 0.0)}));
    g.add_all(256);
    for (std::size_t face = 1; face < 6; ++face) {
        std::vector<double> from(g.scene.surfels.size(), 0.0);
        for (std::size_t k = 0; k < n * n; ++k) from[face * n * n + k] = 1.0;
        from = g.sent(from);
        double mean = 0.0;
        for (std::size_t row = 0; row < n * n; ++row) mean += g.gathered(row, from) / (n * n);
        // Of 25600 rays a fifth: random ones would be off by .0025.
        EXPECT_NEAR(mean, face == 1 ? 0.1998248957 : 0.2000437761, 2.5e-3) << face;
    }
}

TEST(Gathering, HalvesMakeTheWhole) {
    Gathered g(open_scene());
    g.add_all(128);
    std::vector<double> from(g.scene.surfels.size());
    for (std::size_t i = 0; i < from.size(); ++i) from[i] = 1.0 + 0.5 * std::sin(static_cast<double>(i));
    from = g.sent(from);
    for (std::size_t row = 0; row < g.gathering.size(); ++row) {
        double first = 0.0, second = 0.0;
        g.gathering.gather_halves(row, from, 1, &first, &second);
        EXPECT_NEAR(0.5 * (first + second), g.gathered(row, from), 1e-12);
        const TiltedRgb tilted = g.gathering.gather_tilted(row, from, 1);
        EXPECT_NEAR(tilted.value.x, g.gathered(row, from), 1e-12);
        EXPECT_EQ(tilted.value.x, tilted.value.z);
    }
}

TEST(Gathering, HalvesDifferByTheNoiseAndNotByWhereLightComesFrom) {
    // Walls on one side only. Halves that are opposite sides of the hemisphere would differ by as much as there is.
    Surfels eye = shapes::disk({0, 0, 0}, {0, 0, 1}, 0.01), wall;
    add_rectangle(wall, {0.5, -20, 0}, {0, 0, 20}, {0, 40, 0}, 20, 40);
    finish(wall, 0.5, 0.0);
    for (double turn : {0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75}) {
        Surfels turned = wall;
        const double c = std::cos(turn * pi), s = std::sin(turn * pi);
        const auto around = [&](const Vec3& p) { return Vec3{c * p.x - s * p.y, s * p.x + c * p.y, p.z}; };
        for (Vec3& p : turned.positions) p = around(p);
        for (Vec3& n : turned.normals) n = around(n);
        for (Triangle& t : turned.triangles) t = {around(t.a), around(t.b), around(t.c), t.surfel};
        Gathered g(scene_of({eye, turned}));
        g.gathering.add({places_of(g.scene.surfels)[0]}, {256});
        const std::vector<double> from = g.sent(std::vector<double>(g.scene.surfels.size(), 1.0));
        double first = 0.0, second = 0.0;
        g.gathering.gather_halves(0, from, 1, &first, &second);
        EXPECT_GT(g.gathered(0, from), 0.3);
        // Of 128 random rays each, half of which meet it: .06 is one standard error of the difference.
        EXPECT_LT(std::abs(first - second), 0.19) << turn;
    }
}

TEST(Gathering, NearSendersAreSurfelsAndFarOnesGroups) {
    // A wall close by of 16 x 16 patches, and one of 128 x 128 at 24 times the distance. What comes by groups, of all.
    Surfels eye = shapes::disk({0, 0, 0}, {1, 0, 0}, 0.05), near, far;
    add_rectangle(near, {0.3, -1, -1}, {0, 0, 2}, {0, 2, 0}, 16, 16);
    add_rectangle(far, {8, -8, -8}, {0, 0, 16}, {0, 16, 0}, 128, 128);
    finish(near, 0.5, 0.0);
    finish(far, 0.5, 0.0);
    const auto by_groups = [&](const Surfels& wall) {
        Gathered g(scene_of({eye, wall}));
        g.gathering.add({places_of(g.scene.surfels)[0]}, {256});
        std::vector<double> groups(g.tree.size(), 1.0);
        for (std::uint32_t node = 0; node < g.tree.points(); ++node) groups[node] = 0.0;
        const double all = g.gathered(0, g.sent(std::vector<double>(g.scene.surfels.size(), 1.0)));
        EXPECT_GT(all, 0.4);
        return g.gathered(0, groups) / all;
    };
    EXPECT_LT(by_groups(near), 0.1);
    EXPECT_GT(by_groups(far), 0.9);
}

TEST(Gathering, TiltIsTheSlopeOfIrradianceWithTheNormal) {
    // Under a wide lamp, patches that lean by 10 degrees get what a level one says they do.
    Surfels lamp;
    add_rectangle(lamp, {-1, -0.4, 0.8}, {0, 1.4, 0}, {2, 0, 0}, 12, 12);
    finish(lamp, 0.0, 0.0);
    const auto scene = [&](const Vec3& normal) { return scene_of({shapes::disk({0, 0, 0}, normal, 0.01), lamp}); };
    const auto at = [&](const Vec3& normal, TiltedRgb& out) {
        Gathered g(scene(normal));
        g.gathering.add({places_of(g.scene.surfels)[0]}, {16384});
        std::vector<double> from(g.scene.surfels.size(), 1.0);
        out = g.gathering.gather_tilted(0, g.sent(from), 1);
    };
    const Frame frame = frame_around({0, 0, 1});
    TiltedRgb level, leaning;
    at({0, 0, 1}, level);
    for (const Vec3& lean : {normalized({0.17, 0, 1}), normalized({0, 0.17, 1})}) {
        at(lean, leaning);
        const double said =
            dot(lean, frame.n) * level.value.x + dot(lean, frame.u) * level.u.x + dot(lean, frame.v) * level.v.x;
        EXPECT_NEAR(said, leaning.value.x, 0.01 * leaning.value.x);
    }
    EXPECT_GT(std::abs(dot({0, 1, 0}, frame.u) * level.u.x + dot({0, 1, 0}, frame.v) * level.v.x), 0.05);
}

TEST(Gathering, IsTheSameInPartsAndOnOneThread) {
    Gathered all(open_scene(), 3), parts(open_scene(), 3), other(open_scene(), 4);
    all.add_all(64);
    other.add_all(64);
    const std::vector<Place> places = places_of(parts.scene.surfels);
    for (std::size_t k = 0; k < places.size(); k += 37)
        parts.gathering.add({places.begin() + static_cast<std::ptrdiff_t>(k),
                             places.begin() + static_cast<std::ptrdiff_t>(std::min(places.size(), k + 37))},
                            std::vector<int>(std::min(places.size(), k + 37) - k, 64));
    std::vector<double> from(all.scene.surfels.size());
    for (std::size_t i = 0; i < from.size(); ++i) from[i] = std::cos(static_cast<double>(i));
    from = all.sent(from);
    bool differs = false;
    for (std::size_t row = 0; row < all.gathering.size(); ++row) {
        EXPECT_EQ(all.gathered(row, from), parts.gathered(row, from));
        differs = differs || all.gathered(row, from) != other.gathered(row, from);
    }
    EXPECT_TRUE(differs);
}

TEST(Gathering, EmissionAndTheSkyAreInNoLink) {
    // Links carry what is sent, which may be nothing.
    Scene scene = open_scene();
    std::vector<Rgb> emission(scene.surfels.emission.begin(), scene.surfels.emission.end());
    emission[64] = {9, 6, 3};
    scene.surfels.emission = emission;
    scene.lights = {Environment{}};
    std::get<Environment>(scene.lights[0]).radiance = {0.5, 1.0, 2.0};
    Gathered g(scene);
    g.add_all(1024);
    for (std::size_t row = 0; row < 64; ++row) {
        const Rgb sky = g.gathering.sky()[row].value;
        EXPECT_NEAR(sky.x, pi * 0.5 * g.gathering.row(row).escape, 1e-5);  // a constant sky is found by chance alone
        EXPECT_NEAR(sky.z, pi * 2.0 * g.gathering.row(row).escape, 1e-5);
    }
    EXPECT_EQ(g.gathered(0, g.sent(std::vector<double>(g.scene.surfels.size(), 0.0))), 0.0);
}

}  // namespace
}  // namespace surflux
