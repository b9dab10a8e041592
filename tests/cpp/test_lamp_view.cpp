#include "surflux/render/lamp_view.h"

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "refusal.h"
#include "shapes.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {
namespace {

struct View {
    LocalTransfer transfer;
    PatchCorners corners;
    LampView view;

    View(const std::vector<Surfels>& objects, const Camera& camera, const LampViewOptions& options = {},
         std::size_t width = 96, std::size_t height = 72)
        : transfer(transfer_of(std::make_shared<CompiledScene>(shapes::scene_of(objects)))),
          corners(patch_corners(transfer.scene().scene(), transfer.scene().tracer(), transfer.transport().areas)),
          view(transfer, corners, camera, width, height, options) {}

    static LocalTransfer transfer_of(const std::shared_ptr<const CompiledScene>& scene) {
        Figures timings;
        OperatorOptions options;
        options.test_lights = 16;
        return {scene, build_operator(*scene, options, {}, timings), {}};
    }

    LampFrame frame(const std::vector<Light>& lights, const std::vector<Rgb>& reflectance = {}) const {
        LampFrameOptions options;
        options.parts = true;
        return view.frame(lights, reflectance, options);
    }
};

// A room with a box in it, in three colours, and a ball of disks.
std::vector<Surfels> furnished() {
    Surfels room = shapes::cube_inside(8, 0.5, 0.0), box;
    shapes::add_rectangle(box, {0.2, 0.6, 0.4}, {0.3, 0, 0}, {0, 0.3, 0}, 3, 3);
    shapes::add_rectangle(box, {0.2, 0.6, 0}, {0.3, 0, 0}, {0, 0, 0.4}, 3, 3);
    shapes::finish(box, 0.7, 0.0);
    return {room, box, shapes::sphere(300, 0.15, 1.0, 0.6, 0.0, {0.7, 0.5, 0.16})};
}
const Camera inside{{0.5, 0.03, 0.5}, {0.5, 1, 0.4}, {0, 0, 1}, 80.0};
const std::vector<Light> lamps{PointLight{{0.5, 0.4, 0.8}, {1, 2, 3}},
                               AreaLight{{0.3, 0.5, 0.95}, {0, 0.2, 0}, {0.2, 0, 0}, {4, 4, 4}}};

// In a closed room of emission E and reflectance rho all receive and send E / (1 - rho), wherever they are.
TEST(LampView, AUniformFurnaceIsUniform) {
    const View view({shapes::cube_inside(6, 0.5, 1.0)}, inside);
    LampFrameOptions options;
    options.relight.bounces = 40;  // .5^40 is left out
    options.parts = true;
    const LampFrame found = view.view.frame({}, {}, options);
    for (std::size_t k = 0; k < found.radiance.size(); ++k) {
        ASSERT_NEAR(found.direct[k], 1.0 / pi, 1e-6);  // what it emits itself
        ASSERT_NEAR(found.indirect[k], 0.5 * 2.0 / pi, 1e-5);
        ASSERT_FLOAT_EQ(found.radiance[k], found.direct[k] + found.indirect[k]);
    }
}

TEST(LampView, IsTheSameForAnyNumberOfThreads) {
    const View view(furnished(), inside);
    const LampFrame all = view.frame(lamps);
    for (const int threads : {1, 2, 3}) {
        const ThreadLimit limit(threads);
        const View again(furnished(), inside);
        const LampFrame found = again.frame(lamps);
        ASSERT_EQ(found.radiance, all.radiance);
        ASSERT_EQ(found.direct, all.direct);
        ASSERT_EQ(found.indirect, all.indirect);
        ASSERT_EQ(found.shadow_rays, all.shadow_rays);
    }
}

TEST(LampView, AFrameDoesNotDependOnThoseBefore) {
    const View view(furnished(), inside);
    for (int k = 0; k < 100; ++k) {
        const double x = 0.2 + 0.006 * k;
        view.frame({SpotLight{{x, 0.5, 0.9}, normalized({x - 0.5, 0.2, -1}), {1, 1, k * 0.1}}, lamps[1 - k % 2]});
    }
    const View fresh(furnished(), inside);
    const LampFrame found = view.frame(lamps), wanted = fresh.frame(lamps);
    EXPECT_EQ(found.radiance, wanted.radiance);
    EXPECT_EQ(found.direct, wanted.direct);
    EXPECT_EQ(found.indirect, wanted.indirect);
}

TEST(LampView, LampsAreSeenFromTheirFrontsAndNothingIsNotCovered) {
    Surfels floor;
    shapes::add_rectangle(floor, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 8, 8);
    shapes::finish(floor, 0.5, 0.0);
    const View view({floor}, {{0, -3, 1.5}, {0, 0, 0.8}, {0, 0, 1}, 60.0});
    const AreaLight lamp{{-0.4, 0, 1}, {0.8, 0, 0}, {0, 0, 0.6}, {pi, 2 * pi, 3 * pi}};  // towards -y
    AreaLight turned = lamp;
    std::swap(turned.edge_u, turned.edge_v);
    AreaLight below = lamp;
    below.corner.z = -0.7;  // behind the floor
    const std::vector<Light> lights{PointLight{{0, 0, 1}, {0, 0, 0}}, turned, lamp, below};
    const LampFrame found = view.frame(lights);
    const LampSurfaces surfaces = view.view.surfaces(lights, {});
    std::size_t lamp_pixels = 0, nothing = 0, on_floor = 0;
    for (std::size_t p = 0; p < surfaces.index.size(); ++p) {
        const float* direct = &found.direct[3 * p];
        if (surfaces.index[p] == -3) {  // the second of three area lights
            ++lamp_pixels;
            EXPECT_FLOAT_EQ(direct[0], 1.0f);
            EXPECT_FLOAT_EQ(direct[2], 3.0f);
            EXPECT_EQ(surfaces.normal[3 * p + 1], -1.0f);
            EXPECT_EQ(surfaces.albedo[3 * p], 0.0f);
            EXPECT_EQ(found.indirect[3 * p], 0.0f);
        } else if (surfaces.index[p] == -1) {
            ++nothing;
            EXPECT_EQ(direct[1], 0.0f);
            EXPECT_EQ(found.coverage[p], 0.0f);
            EXPECT_TRUE(std::isinf(surfaces.depth[p]));
        } else {
            ASSERT_GE(surfaces.index[p], 0);
            ++on_floor;
            EXPECT_EQ(found.coverage[p], 1.0f);
            EXPECT_EQ(surfaces.albedo[3 * p], 0.5f);
            EXPECT_EQ(surfaces.normal[3 * p + 2], 1.0f);
        }
    }
    EXPECT_GT(lamp_pixels, 100u);
    EXPECT_GT(nothing, 1000u);
    EXPECT_GT(on_floor, 500u);
}

// What is drawn finer is the mean of what a finer picture shows.
TEST(LampView, SubpixelsAreAveraged) {
    LampViewOptions two;
    two.samples = 2;
    const View fine(furnished(), inside, {}, 96, 72), averaged(furnished(), inside, two, 48, 36);
    const LampFrame single = fine.frame(lamps), mean = averaged.frame(lamps);
    ASSERT_EQ(mean.radiance.size(), single.radiance.size() / 4);
    for (std::size_t y = 0; y < 36; ++y)
        for (std::size_t x = 0; x < 48; ++x)
            for (std::size_t c = 0; c < 3; ++c) {
                const auto at = [&](std::size_t column, std::size_t row) {
                    return single.radiance[3 * (row * 96 + column) + c];
                };
                const float wanted =
                    0.25f * (at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1));
                ASSERT_NEAR(mean.radiance[3 * (y * 48 + x) + c], wanted, 1e-5f * wanted);
            }
}

TEST(LampView, AnotherReflectanceIsThatOfAnotherScene) {
    std::vector<Surfels> other = furnished();
    std::vector<Rgb> own, reflectance;
    for (Surfels& s : other) {
        own.insert(own.end(), s.reflectance.begin(), s.reflectance.end());
        for (std::size_t i = 0; i < s.size(); ++i) reflectance.push_back({0.1, 0.8, 0.4});
        s.reflectance = Colors(s.size(), {0.1, 0.8, 0.4});
    }
    const View view(furnished(), inside), fresh(other, inside);
    const LampFrame found = view.frame(lamps, reflectance), wanted = fresh.frame(lamps), usual = view.frame(lamps);
    EXPECT_EQ(found.direct, wanted.direct);
    // A tenth of red light is reflected, and then a tenth of that, where it was half of it or more.
    double red = 0.0, usual_red = 0.0;
    for (std::size_t k = 0; k < found.indirect.size(); k += 3) {
        red += static_cast<double>(found.indirect[k]);
        usual_red += static_cast<double>(usual.indirect[k]);
    }
    EXPECT_LT(red, usual_red / 25.0);
    EXPECT_GT(red, usual_red / 250.0);
    EXPECT_EQ(view.frame(lamps, own).radiance, usual.radiance);
}

TEST(LampView, RefusesWhatItCannotTake) {
    LampViewOptions none;
    none.samples = 0;
    EXPECT_EQ(refusal([&] { View({shapes::cube_inside(2, 0.5, 1.0)}, inside, none); }),
              "samples: wanted at least 1, got 0");
    LampViewOptions no_cell;
    no_cell.shadow_cell = 0;
    EXPECT_EQ(refusal([&] { View({shapes::cube_inside(2, 0.5, 1.0)}, inside, no_cell); }),
              "shadow_cell: wanted at least 1");
}

}  // namespace
}  // namespace surflux
