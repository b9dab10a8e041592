#include <gtest/gtest.h>

#include "shapes.h"
#include "surflux/radiosity/lit_points.h"

namespace surflux {
namespace {

// Direct light of the four parts of a unit patch half under a small one, with `before` of nine other surfels in front
// of it in the scene's order, which lie behind it and within its bounds.
std::vector<Rgb> light_of_parts(int before) {
    Surfels s;
    const auto add_others = [&](int from, int to) {
        for (int k = from; k < to; ++k) shapes::add_rectangle(s, {0.1 * k, 0, -0.5}, {0, 0.1, 0}, {0.1, 0, 0}, 1, 1);
    };
    add_others(0, before);
    const auto patch = static_cast<std::uint32_t>(before);
    shapes::add_rectangle(s, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1, 1);
    shapes::add_rectangle(s, {0.3, 0.3, 0.5}, {0.4, 0, 0}, {0, 0.4, 0}, 1, 1);
    add_others(before, 9);
    shapes::finish(s, 0.5, 0.0);
    const Scene scene = shapes::scene_of({s}, {AreaLight{{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {1, 1, 1}}});
    SurfelTree tree(scene, build_hierarchy(scene.surfels, scene.object, {}), 100);
    const Tracer tracer(scene);
    const SurfelPoints points(scene.surfels);
    LitPoints lights(scene, points, tracer, tree, nullptr, nullptr, {}, 0, 7);
    lights.update();
    SurfelTree::Child below[4];
    for (int k = 0; k < 4; ++k)
        below[k] = {{k % 2 ? 0.75 : 0.25, k / 2 ? 0.75 : 0.25, 0.0}, {0, 0, 1}, {0.5, 0.5, 0.5}};
    const std::uint32_t first = tree.split(patch, below);
    tree.share_patch(patch);
    lights.update();
    std::vector<Rgb> out;
    for (std::uint32_t k = 0; k < 4; ++k) out.push_back(lights[first + k]);
    return out;
}

// Parts are numbered among themselves. Part k is not surfel k, whatever it was cut from: neither its random numbers nor
// the rule at its rays' beginning may depend on the number that its patch happens to have.
TEST(LitPoints, PartsDoNotDependOnTheNumberOfTheirPatch) {
    const std::vector<Rgb> alone = light_of_parts(0), second = light_of_parts(1), tenth = light_of_parts(9);
    for (std::size_t k = 0; k < 4; ++k) {
        EXPECT_GT(alone[k].x, 0.01) << k;
        EXPECT_EQ(alone[k].x, second[k].x) << k;
        EXPECT_EQ(alone[k].x, tenth[k].x) << k;
    }
}

// Each place draws its own random numbers, on a disk or in the air.
TEST(LitPoints, PlacesOffAllDisksHaveStreamsOfTheirOwn) {
    const Place one{{1, 2, 3}, {0, 0, 1}, Hit::none, Place::point},
        other{{1, 2, 4}, {0, 0, 1}, Hit::none, Place::point};
    EXPECT_NE(stream_of(one), stream_of(other));
}

}  // namespace
}  // namespace surflux
