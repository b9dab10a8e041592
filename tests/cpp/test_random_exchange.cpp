#include <gtest/gtest.h>

#include "shapes.h"
#include "surflux/core/sampling.h"
#include "surflux/radiosity/exchange.h"

namespace surflux {
namespace {

// Disks and rectangles anywhere, on few places in every other scene, so that some touch and coincide.
Scene random_scene(std::uint64_t seed) {
    Random random(seed);
    const auto anywhere = [&] {
        Vec3 p{2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0};
        if (seed % 2 == 0) p = {std::round(2.0 * p.x) / 2.0, std::round(2.0 * p.y) / 2.0, std::round(2.0 * p.z) / 2.0};
        return p;
    };
    const auto direction = [&] {
        return normalized({random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5});
    };
    std::vector<Surfels> objects;
    for (int k = 0; k < 24; ++k) {
        const double radius = 0.05 + 0.45 * random.uniform();
        objects.push_back(shapes::disk(anywhere(), direction(), radius));
    }
    for (int k = 0; k < 3; ++k) {
        Surfels sheet;
        const Frame frame = frame_around(direction());
        shapes::add_rectangle(sheet, anywhere(), frame.u, 0.5 * frame.v, 4, 2);
        shapes::finish(sheet, 0.5, 0.0);
        objects.push_back(sheet);
    }
    return shapes::scene_of(objects);
}

TEST(RandomExchange, IsSymmetricAndNoObstacleAddsToIt) {
    std::size_t hidden = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const Scene scene = random_scene(seed);
        const Tracer tracer(scene);
        const Exchange open = exchange_of_all_pairs(scene, nullptr, {}, seed);
        const Exchange obstructed = exchange_of_all_pairs(scene, &tracer, {}, seed);
        for (std::size_t i = 0; i < open.size; ++i)
            for (std::size_t j = 0; j < open.size; ++j) {
                const double all = open.at(i, j), seen = obstructed.at(i, j);
                ASSERT_TRUE(std::isfinite(all));
                ASSERT_GE(seen, 0.0);
                ASSERT_LE(seen, all) << seed << ": " << i << " " << j;
                ASSERT_EQ(seen, obstructed.at(j, i));
                ASSERT_LE(all, std::min(open.areas[i], open.areas[j]) * (1.0 + 1e-6));
                hidden += seen < all;
            }
    }
    EXPECT_GT(hidden, 10000u);
}

}  // namespace
}  // namespace surflux
