#include <gtest/gtest.h>

#include "shapes.h"
#include "surflux/core/random.h"
#include "surflux/lights/sample_points.h"
#include "surflux/radiosity/pair_exchange.h"
#include "surflux/radiosity/shafts.h"
#include "surflux/trace/tracer.h"

namespace surflux {
namespace {

using shapes::scene_of;

TEST(Shafts, NothingIsBetweenTheWallsOfAnEmptyRoomHoweverItIsTurned) {
    Surfels room = shapes::cube_inside(5, 0.5, 0.0);
    for (const bool turned : {false, true}) {
        if (turned) {
            const Frame frame = frame_around(normalized({1.0, -0.4, 0.3}));
            for (Triangle& t : room.triangles)
                for (Vec3* p : {&t.a, &t.b, &t.c}) *p = frame.to_world(*p);
            for (Vec3& p : room.positions) p = frame.to_world(p);
            for (Vec3& n : room.normals) n = frame.to_world(n);
        }
        const Scene scene = scene_of({room});
        const Shafts shafts(scene);
        const PairExchange pairs(scene);
        std::size_t empty = 0, all = 0;
        for (std::uint32_t i = 0; i < scene.surfels.size(); ++i)
            for (std::uint32_t j = i + 1; j < scene.surfels.size(); ++j) {
                if (pairs(i, j).exchange <= 0.0) continue;
                ++all;
                empty += shafts.empty(i, j);
            }
        EXPECT_EQ(empty, all);
    }
}

TEST(Shafts, WhereOneIsEmptyNoRayIsBlocked) {
    // A room with a ball of disks and a leaning sheet in it.
    Surfels sheet;
    shapes::add_rectangle(sheet, {0.2, 0.1, 0.1}, {0.3, 0.2, 0.1}, {-0.1, 0.1, 0.6}, 3, 3);
    shapes::finish(sheet, 0.5, 0.0);
    const Scene scene =
        scene_of({shapes::cube_inside(4, 0.5, 0.0), shapes::sphere(60, 0.15, 1.0, 0.5, 0.0, {0.7, 0.6, 0.4}), sheet});
    const Shafts shafts(scene);
    const Tracer tracer(scene);
    const SurfelPoints points(scene.surfels);
    Random random(7);
    int empty = 0, blocked = 0;
    const auto n = static_cast<std::uint32_t>(scene.surfels.size());
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = i + 1; j < n; ++j) {
            for (int k = 0; k < 4; ++k) {
                const Vec3 from = points.at(i, random.uniform(), random.uniform());
                const Vec3 to = points.at(j, random.uniform(), random.uniform());
                if (dot(to - from, scene.surfels.normals[i]) <= 1e-6 ||
                    dot(from - to, scene.surfels.normals[j]) <= 1e-6)
                    continue;
                const bool none = shafts.empty(i, j), free = tracer.free(segment(tracer.on(i, from), to, j));
                ASSERT_TRUE(free || !none) << i << " " << j;
                empty += none;
                blocked += !free;
            }
        }
    EXPECT_GT(empty, 2000);
    EXPECT_GT(blocked, 2000);
}

}  // namespace
}  // namespace surflux
