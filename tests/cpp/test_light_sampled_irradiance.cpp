#include <gtest/gtest.h>

#include <cmath>

#include "shapes.h"
#include "surflux/lights/direct_at.h"
#include "surflux/lights/light_sampled_irradiance.h"
#include "surflux/lights/polygon.h"

namespace surflux {
namespace {

using shapes::add_rectangle;
using shapes::disk;
using shapes::finish;
using shapes::scene_of;

const Vec3 up{0, 0, 1}, down{0, 0, -1};

// A floor that makes lamps small beside it, with its middle patch first.
Surfels floor_of(int n) {
    Surfels s;
    add_rectangle(s, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, n, n);
    finish(s, 0.5, 0.0);
    return s;
}

Surfels lamp_at(double side, double height, double exitance) {
    Surfels s;
    add_rectangle(s, {-side / 2, -side / 2, height}, {0, side, 0}, {side, 0, 0}, 2, 2);
    finish(s, 0.0, exitance);
    return s;
}

// Light samples and what hemisphere rays find, together: the irradiance at a place.
double both_ways(const Scene& scene, const Place& place, LightSampler::Sources sources, int rays) {
    const Tracer tracer(scene);
    const LightSampler lights(scene, LightSampler::usual_small_emitters, sources);
    const double light_sampled =
        light_sampled_irradiance(tracer, lights, SurfelPoints(scene.surfels), {place}, {rays, rays}, 0)[0].x;
    EvenPoints even(2, 9, 9);
    const Frame frame = frame_around(place.normal);
    std::vector<Ray> cosine;
    for (int k = 0; k < rays; ++k) {
        const double* u = even.next();
        cosine.push_back(
            {{place.position, place.normal, place.surfel}, frame.to_world(square_to_cosine_hemisphere(u[0], u[1]))});
    }
    std::vector<Hit> hits;
    tracer.closest(cosine, hits);
    double found = 0.0;
    for (std::size_t k = 0; k < cosine.size(); ++k)
        found += lights.found(place.position, place.normal, cosine[k].direction, hits[k]).x / rays;
    return light_sampled + found;
}

TEST(LightSampledIrradiance, LampsGiveWhatLambertSays) {
    // Shares by the balance heuristic: neither way alone is the irradiance, both together are.
    for (double height : {0.1, 0.5, 1.5}) {
        const Scene scene = scene_of({floor_of(8), lamp_at(0.4, height, 5.0)});
        const Vec3 corners[4] = {{-0.2, -0.2, height}, {-0.2, 0.2, height}, {0.2, 0.2, height}, {0.2, -0.2, height}};
        for (const Vec3& at : {Vec3{0.01, 0.02, 0}, Vec3{0.6, 0.3, 0}}) {
            const double wanted = 5.0 * std::abs(element_to_polygon(at, up, corners, 4));
            const Tracer tracer(scene);
            const Place place{at, up, tracer.departure(at, up).surfel};
            EXPECT_NEAR(both_ways(scene, place, LightSampler::Sources::surfels, 16384), wanted, 0.01 * wanted)
                << height;
        }
    }
}

TEST(LightSampledIrradiance, AllThatEmittersBringIsWhatTheFormFactorsSay) {
    // A lamp that touches the floor along an edge: the balance heuristic leaves a sixth of what there is, most of it
    // near, to rays over the hemisphere. Two unit squares at a right angle exchange 0.2000438 (Hottel; Howell C-14).
    Surfels wall, floor, rest;
    add_rectangle(floor, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 4, 4);
    add_rectangle(wall, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}, 4, 4);
    add_rectangle(rest, {-20, -20, -1}, {40, 0, 0}, {0, 40, 0}, 8, 8);
    finish(floor, 0.5, 0.0), finish(wall, 0.0, 3.0), finish(rest, 0.0, 0.0);
    const Scene scene = scene_of({floor, wall, rest});
    const Tracer tracer(scene);
    const LightSampler emitters = LightSampler::of_surfels(scene);
    const SurfelPoints points(scene.surfels);
    std::vector<Place> places = places_of(scene.surfels);
    places.resize(16);
    double all = 0.0;
    for (const Rgb& found : emitted_irradiance(tracer, emitters, points, places, {256, 256}, 3)) all += found.x / 16.0;
    EXPECT_NEAR(all, 3.0 * 0.2000438, 3e-3 * 3.0 * 0.2);  // some standard errors of 4096 rays each way
    double light_sampled = 0.0;
    for (const Rgb& found : light_sampled_irradiance(tracer, emitters, points, places, {256, 256}, 3))
        light_sampled += found.x / 16.0;
    EXPECT_LT(light_sampled, 0.9 * all);
}

TEST(LightSampledIrradiance, WhatStandsBetweenBlocksAndTheBackGivesNothing) {
    Surfels lid;
    add_rectangle(lid, {-1, -1, 0.5}, {2, 0, 0}, {0, 2, 0}, 1, 1);
    finish(lid, 0.0, 0.0);
    const Scene open = scene_of({floor_of(8), lamp_at(0.4, 1.0, 5.0)}),
                shut = scene_of({floor_of(8), lamp_at(0.4, 1.0, 5.0), lid});
    const auto sampled_at = [](const Scene& scene, const Vec3& at, const Vec3& normal) {
        const Tracer tracer(scene);
        const LightSampler lights = LightSampler::of_surfels(scene);
        return light_sampled_irradiance(tracer, lights, SurfelPoints(scene.surfels),
                                        {{at, normal, tracer.departure(at, normal).surfel}}, {}, 0)[0]
            .x;
    };
    EXPECT_GT(sampled_at(open, {0.1, 0.1, 0}, up), 0.0);
    EXPECT_EQ(sampled_at(shut, {0.1, 0.1, 0}, up), 0.0);
    EXPECT_EQ(sampled_at(open, {0.1, 0.1, 0}, down), 0.0);
    EXPECT_EQ(sampled_at(open, {0.1, 0.1, 1.5}, down), 0.0);  // above the lamp is its back
}

TEST(LightSampledIrradiance, WithoutLampsThereIsNothing) {
    const Scene dark = scene_of({floor_of(4)});
    const Tracer tracer(dark);
    const LightSampler lights = LightSampler::of_surfels(dark);
    EXPECT_TRUE(lights.empty());
    const std::vector<Rgb> none =
        light_sampled_irradiance(tracer, lights, SurfelPoints(dark.surfels), places_of(dark.surfels), {}, 0);
    ASSERT_EQ(none.size(), 16u);
    for (const Rgb& c : none) EXPECT_EQ(c.x + c.y + c.z, 0.0);
    EXPECT_TRUE(light_sampled_irradiance(tracer, lights, SurfelPoints(dark.surfels), {}, {}, 0).empty());
}

Environment image_sky() {
    Environment e;
    e.width = 32;
    e.height = 16;
    e.up = up;
    for (std::size_t row = 0; row < e.height; ++row)
        for (std::size_t column = 0; column < e.width; ++column)
            e.pixels.push_back(row < 8 ? Rgb{2, 1, 0.5} : Rgb{0, 0, 0});
    return e;
}

TEST(LightSampledIrradiance, AHalfSkyIsPiTimesItsRadiance) {
    const Scene scene = scene_of({floor_of(4)}, {image_sky()});
    const Tracer tracer(scene);
    const Vec3 at{0.3, 0.2, 0};
    const Place place{at, up, tracer.departure(at, up).surfel};
    // By light samples and hemisphere rays, or by light samples alone.
    for (const auto sources : {LightSampler::Sources::all, LightSampler::Sources::whole_images})
        EXPECT_NEAR(both_ways(scene, place, sources, 16384), 2 * pi, 0.02 * pi);
    EXPECT_TRUE(LightSampler(scene, 0.0, LightSampler::Sources::constant_sky).empty());
}

Rgb at_point(const Scene& scene, const Vec3& at, const Vec3& normal, int rays = 512) {
    const Tracer tracer(scene);
    return direct_at(scene, tracer, {at}, {normal}, rays, 0)[0];
}

TEST(DirectAt, LightsComeOutAsClosedFormsHaveThem) {
    const Vec3 at{0.3, 0.2, 0};
    const double r2 = 0.09 + 0.04 + 4.0;
    EXPECT_NEAR(at_point(scene_of({floor_of(8)}, {PointLight{{0, 0, 2}, {50, 25, 0}}}), at, up).y,
                25 * 2 / std::pow(r2, 1.5), 1e-12);
    EXPECT_NEAR(at_point(scene_of({floor_of(8)}, {DirectionalLight{down, {3, 2, 1}}}), at, up).x, 3.0, 1e-12);
    const AreaLight lamp{{-0.5, -0.5, 1}, {0, 1, 0}, {1, 0, 0}, {2, 2, 2}};
    const Vec3 corners[4] = {{-0.5, -0.5, 1}, {-0.5, 0.5, 1}, {0.5, 0.5, 1}, {0.5, -0.5, 1}};
    EXPECT_NEAR(at_point(scene_of({floor_of(8)}, {lamp}), at, up).x,
                2 * std::abs(element_to_polygon(at, up, corners, 4)), 1e-9);
    // At the place itself, and not what its surfel has.
    const double here = at_point(scene_of({floor_of(2)}, {PointLight{{0, 0, 0.1}, {1, 1, 1}}}), {0.02, 0, 0}, up).x;
    EXPECT_NEAR(here, 0.1 / std::pow(0.0004 + 0.01, 1.5), 1e-9);
}

TEST(DirectAt, ShadowsAreSharp) {
    Surfels lid;
    add_rectangle(lid, {-0.5, -0.5, 1}, {1, 0, 0}, {0, 1, 0}, 1, 1);
    finish(lid, 0.0, 0.0);
    const Scene scene = scene_of({floor_of(4), lid}, {DirectionalLight{down, {3, 3, 3}}});
    for (double y : {-0.3, 0.0, 0.4}) {
        EXPECT_EQ(at_point(scene, {0.499, y, 0}, up).x, 0.0);
        EXPECT_NEAR(at_point(scene, {0.501, y, 0}, up).x, 3.0, 1e-12);
    }
}

TEST(DirectAt, SkiesOfOneColourAndOfImages) {
    Environment even;
    even.radiance = {1, 2, 3};
    EXPECT_NEAR(at_point(scene_of({floor_of(4)}, {even}), {0.1, 0, 0}, up).z, 3 * pi, 1e-9);
    const Rgb image = at_point(scene_of({floor_of(4)}, {image_sky()}), {0.1, 0, 0}, up, 16384);
    EXPECT_NEAR(image.x, 2 * pi, 0.02 * pi);
    EXPECT_NEAR(image.z, 0.5 * pi, 0.005 * pi);
}

TEST(DirectAt, NoPointsNoLight) {
    const Scene scene = scene_of({floor_of(4)}, {image_sky()});
    const Tracer tracer(scene);
    EXPECT_TRUE(direct_at(scene, tracer, {}, {}, 64, 0).empty());
}

}  // namespace
}  // namespace surflux
