#include <gtest/gtest.h>

#include "shapes.h"
#include "surflux/radiosity/light_particles.h"

namespace surflux {
namespace {

// All walls of a cube send 1: each receives 1, whatever it is cut into.
TEST(LightParticles, BringWhatThereIs) {
    const Scene scene = shapes::scene_of({shapes::cube_inside(12, 0.5, 0.0)});
    const Tracer tracer(scene);
    const SurfelTree tree(scene, build_hierarchy(scene.surfels, scene.object, {}), 0);
    std::vector<double> sent(tree.size(), 1.0);
    LightParticles particles;
    EXPECT_TRUE(particles.empty());
    particles.shoot(tree, tracer, sent, 1, 3, {});
    Cut cut;
    const auto [from, to] = tree.level_of_at_least(20);
    for (std::uint32_t node = from; node < to; ++node) cut.nodes.push_back(node);
    cut.find_places(tree);
    const std::vector<double> found = particles.irradiance(tree, cut);
    for (std::size_t k = 0; k < found.size(); ++k) {
        const double particles_here = 65536.0 * tree.area(cut.nodes[k]) / 6.0;
        EXPECT_NEAR(found[k], 1.0, 4.0 / std::sqrt(particles_here)) << k;
        // They come from the front of the node.
        const std::uint32_t p = tree.representative(cut.nodes[k]);
        std::vector<Aim> aims;
        particles.aims_of(cut.nodes[k], tree, tree.position(p), aims);
        EXPECT_FALSE(aims.empty());
        for (const Aim& aim : aims) EXPECT_GT(dot(aim.direction, tree.normal(p)), -1e-9);
    }
}

TEST(LightParticles, OfNoLightThereAreNone) {
    const Scene scene = shapes::scene_of({shapes::cube_inside(12, 0.5, 0.0)});
    const Tracer tracer(scene);
    const SurfelTree tree(scene, build_hierarchy(scene.surfels, scene.object, {}), 0);
    LightParticles particles;
    particles.shoot(tree, tracer, std::vector<double>(tree.size(), 0.0), 1, 3, {});
    EXPECT_TRUE(particles.empty());
}

}  // namespace
}  // namespace surflux
