#include "surflux/render/pixel_light.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "shapes.h"
#include "surflux/core/parallel.h"
#include "surflux/lights/polygon.h"

namespace surflux {
namespace {

// A floor of 6 x 6 at height 0 and a screen at height 1, seen from below the screen, under lamps at height 2.
struct Room {
    CompiledScene compiled;
    PixelPlaces places;
    std::uint32_t floor_surfels;

    explicit Room(const std::vector<Surfels>& screens, std::size_t width = 160, std::size_t height = 120)
        : compiled(scene(screens)),
          places(pixel_places(compiled, {{0.2, -5, 0.9}, {0, 0, 0}, {0, 0, 1}, 50.0}, width, height)),
          floor_surfels(400) {}

    static Scene scene(const std::vector<Surfels>& screens) {
        Surfels floor;
        shapes::add_rectangle(floor, {-3, -3, 0}, {6, 0, 0}, {0, 6, 0}, 20, 20);
        shapes::finish(floor, 0.5, 0.0);
        std::vector<Surfels> all{floor};
        all.insert(all.end(), screens.begin(), screens.end());
        return shapes::scene_of(all);
    }

    bool is_floor(std::size_t p) const { return places.is_seen(p) && places.surfel[p] < floor_surfels; }

    std::vector<float> light(const std::vector<Light>& lights, std::size_t side = 4,
                             const PixelLightOptions& options = {}, std::size_t* rays = nullptr) const {
        const SmoothCells cells(places, side);
        PixelLight::Scratch scratch;
        std::vector<float> out;
        const std::size_t taken =
            PixelLight(compiled.tracer(), places, cells).irradiance(lights, options, scratch, out);
        if (rays) *rays = taken;
        return out;
    }
};

Surfels square(const Vec3& corner, double side) {
    Surfels s;
    shapes::add_rectangle(s, corner, {side, 0, 0}, {0, side, 0}, 2, 2);
    shapes::finish(s, 0.5, 0.0);
    return s;
}

TEST(PixelLight, IsTheInverseSquareAndTheCosineToTheRoundingOfFloats) {
    const Room room({});
    const Vec3 lamp{0.4, -0.3, 2.0};
    const std::vector<float> found = room.light({PointLight{lamp, {1, 2, 4}}});
    const PixelRays& rays = room.places.rays;
    std::size_t seen = 0;
    for (std::size_t p = 0; p < room.places.size(); ++p) {
        if (!room.is_floor(p)) continue;
        ++seen;
        const Vec3 d = rays.direction(static_cast<double>(p % rays.width), static_cast<double>(p / rays.width));
        const Vec3 place = rays.frame.eye - rays.frame.eye.z / d.z * d;
        const Vec3 way = lamp - place;
        const double wanted = way.z / std::pow(length(way), 3);
        // Places are floats from an eye up to 9 away, off by 9 * 2^-24 = 5e-7 along each axis; the lamp is 2 away, so
        // that its kernel, of the third power, is off by 3 * sqrt(3) * 5e-7 / 2 = 1.4e-6 at most, and by 3 roundings.
        for (std::size_t c = 0; c < 3; ++c)
            ASSERT_NEAR(found[3 * p + c] / (wanted * std::pow(2.0, c)), 1.0, 1.6e-6) << p;
    }
    EXPECT_GT(seen, 5000u);
}

// The lamp is twice as high as the screen: a place on the floor is in shadow where the middle between it and the lamp
// lies in the screen.
TEST(PixelLight, TheShadowOfASquareIsThatSquareTwiceAsLarge) {
    const Room room({square({-0.5, -0.4, 1.0}, 1.0)});
    const Vec3 lamp{0.13, -0.21, 2.0};
    for (const std::size_t side : {1u, 4u, 7u}) {
        std::size_t rays = 0, lit = 0, dark = 0;
        const std::vector<float> found = room.light({PointLight{lamp, {1, 1, 1}}}, side, {}, &rays);
        for (std::size_t p = 0; p < room.places.size(); ++p) {
            if (!room.is_floor(p)) continue;
            const Vec3 middle = 0.5 * (room.places.place(p) + lamp);
            const double within = std::min({middle.x + 0.5, 0.5 - middle.x, middle.y + 0.4, 0.6 - middle.y});
            if (std::abs(within) < 1e-6) continue;  // where rounding decides
            (within > 0.0 ? dark : lit) += 1;
            ASSERT_EQ(found[3 * p] == 0.0f, within > 0.0) << p << " side " << side;
        }
        EXPECT_GT(dark, 200u);
        EXPECT_GT(lit, 3000u);
        if (side > 1) {
            EXPECT_LT(rays, (lit + dark) / 2);
        }
    }
}

// Some one and a half pixels wide, a shadow is not missed where it is long: a probe meets it somewhere, and it is
// followed.
TEST(PixelLight, ALineIsFollowedFromWhereAProbeMeetsIt) {
    Surfels wire;
    shapes::add_rectangle(wire, {-0.3, -1.8, 1.0}, {0.5, 2.2, 0}, {0.03, -0.005, 0}, 1, 1);
    shapes::finish(wire, 0.5, 0.0);
    const Room room({wire});
    const std::vector<Light> lamp{PointLight{{0.1, 0.2, 2.0}, {1, 1, 1}}};
    const std::vector<float> every = room.light(lamp, 1), some = room.light(lamp, 4);
    EXPECT_EQ(every, some);
    std::size_t dark = 0;
    for (std::size_t p = 0; p < room.places.size(); ++p) dark += room.is_floor(p) && every[3 * p] == 0.0f;
    EXPECT_GT(dark, 30u);
    EXPECT_LT(dark, 200u);
}

TEST(PixelLight, SpotsAndTheSunAgreeWithARayForEachPixel) {
    const Room room({square({-0.9, -0.9, 1.0}, 0.6), square({0.3, 0.2, 0.7}, 0.5)});
    const std::vector<Light> lights{SpotLight{{0.5, -0.5, 2.0}, normalized({-0.2, 0.1, -1}), {3, 2, 1}, 60.0, 20.0},
                                    DirectionalLight{normalized({0.3, 0.4, -1}), {1, 1, 2}}};
    EXPECT_EQ(room.light(lights, 1), room.light(lights, 4));
    EXPECT_EQ(room.light({Environment{}}), std::vector<float>(3 * room.places.size(), 0.0f));
}

// The screen covers x < 0 at half the height of the lamp, so that a place sees of it what lies beyond -x: a rectangle,
// whose kernel is known.
struct Penumbra {
    Room room{{half_plane()}};
    AreaLight lamp{{-0.5, -0.5, 2.0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 1}};

    static Surfels half_plane() {
        Surfels s;
        shapes::add_rectangle(s, {-4, -4, 1.0}, {4, 0, 0}, {0, 8, 0}, 1, 1);
        shapes::finish(s, 0.5, 0.0);
        return s;
    }
    static double kernel(const Vec3& place, double from) {
        const Vec3 corners[4] = {{from, -0.5, 2}, {from, 0.5, 2}, {0.5, 0.5, 2}, {0.5, -0.5, 2}};
        return element_to_polygon(place, {0, 0, 1}, corners, 4);
    }
    // The largest error and the mean one, of the unoccluded kernel, over pixels that see the lamp in part.
    std::pair<double, double> errors(std::size_t side, int rays) const {
        const std::vector<float> found = room.light({lamp}, side, {rays, 3});
        double largest = 0.0, sum = 0.0;
        std::size_t count = 0;
        for (std::size_t p = 0; p < room.places.size(); ++p) {
            if (!room.is_floor(p)) continue;
            const Vec3 place = room.places.place(p);
            const double all = kernel(place, -0.5), wanted = place.x > 0.5    ? all
                                                             : place.x < -0.5 ? 0.0
                                                                              : kernel(place, -place.x);
            const double off = (static_cast<double>(found[3 * p]) - wanted) / all;
            if (std::abs(place.x) > 0.501) {
                EXPECT_NEAR(off, 0.0, 3e-6) << place.x;
                continue;
            }
            largest = std::max(largest, std::abs(off));
            sum += off;
            ++count;
        }
        EXPECT_GT(count, 500u);
        return {largest, sum / static_cast<double>(count)};
    }
};

// One of n stratified points lies in each of n strips along the lamp: of those before the edge, at most one is counted
// wrongly. Points of this lamp count by up to 1.3 times their mean.
TEST(PixelLight, PenumbraeAreRightToAStratum) {
    const Penumbra penumbra;
    for (const int rays : {16, 256}) {
        const auto [largest, mean] = penumbra.errors(4, rays);
        EXPECT_LT(largest, 1.3 / rays);
        EXPECT_NEAR(mean, 0.0, 0.1 / rays);  // random shifts cancel
    }
}

TEST(PixelLight, PenumbraeAgreeWithFineSamplingOfEachPixel) {
    const Penumbra penumbra;
    const std::vector<float> coarse = penumbra.room.light({penumbra.lamp}, 4, {16, 1}),
                             fine = penumbra.room.light({penumbra.lamp}, 1, {1024, 2});
    const float full = *std::max_element(fine.begin(), fine.end());
    for (std::size_t k = 0; k < fine.size(); ++k) ASSERT_NEAR(coarse[k], fine[k], full * 1.3 * (1.0 / 16 + 1.0 / 1024));
}

TEST(PixelLight, IsTheSameForAnyNumberOfThreads) {
    const Room room({square({-0.5, -0.4, 1.0}, 1.0)});
    const std::vector<Light> lights{PointLight{{0.1, 0.2, 2.0}, {1, 2, 3}},
                                    AreaLight{{-0.5, -0.5, 2.0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 1}}};
    const std::vector<float> all = room.light(lights);
    for (const int threads : {1, 2, 3}) {
        const ThreadLimit limit(threads);
        ASSERT_EQ(room.light(lights), all);
    }
}

}  // namespace
}  // namespace surflux
