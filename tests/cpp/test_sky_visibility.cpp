#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "shapes.h"
#include "surflux/core/sampling.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/trace/tracer.h"
#include "surflux/transfer/sky_visibility.h"

namespace surflux {
namespace {

std::vector<float> seen_from(const Scene& scene, std::uint32_t i, int rays, int order) {
    const Tracer tracer(scene);
    const SurfelPoints points(scene.surfels);
    const SkyVisibility visibility(points, tracer, order, 3);
    SkyVisibility::Scratch scratch;
    std::vector<float> out(visibility.size());
    visibility.find({scene.surfels.positions[i], scene.surfels.normals[i], i}, rays, scratch, out.data());
    return out;
}

TEST(SkyVisibility, IsOneAllOverFromConvexBodiesAndNothingInClosedOnes) {
    Scene outside, inside;
    append(outside, shapes::sphere(500, 1.0, 1.0, 0.5, 0.0));
    append(inside, shapes::sphere(2000, 1.0, -1.0, 0.5, 0.0));
    const std::vector<float> open = seen_from(outside, 17, 64, 7), closed = seen_from(inside, 17, 64, 7);
    EXPECT_FLOAT_EQ(open[0], static_cast<float>(std::sqrt(4.0 * pi)));
    for (std::size_t i = 1; i < open.size(); ++i) EXPECT_EQ(open[i], 0.0f);
    for (const float v : closed) EXPECT_EQ(v, 0.0f);
}

// A wall that stands on a plane and goes up to the sky leaves a half of it, and below the horizon the mirror image of
// that: the harmonics of x < 0.
TEST(SkyVisibility, BesideAHighWallIsHalfTheSphere) {
    Scene scene;
    Surfels plane, wall;
    shapes::add_rectangle(plane, {-1.0, -1.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 2.0, 0.0}, 1, 1);
    shapes::add_rectangle(wall, {0.0, -1e4, -10.0}, {0.0, 2e4, 0.0}, {0.0, 0.0, 2e4}, 1, 1);
    shapes::finish(plane, 0.5, 0.0);
    shapes::finish(wall, 0.5, 0.0);
    append(scene, plane);
    append(scene, wall);
    const std::vector<float> seen = seen_from(scene, 0, 4096, 3);
    const double mean = std::sqrt(pi), along_x = -std::sqrt(3.0 / (4.0 * pi)) * pi;
    const double expected[9] = {mean, 0.0, 0.0, along_x, 0.0, 0.0, 0.0, 0.0, 0.0};
    for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(seen[i], expected[i], 0.03) << i;
}

}  // namespace
}  // namespace surflux
