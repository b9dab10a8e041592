#include <gtest/gtest.h>

#include <algorithm>

#include "shapes.h"
#include "surflux/core/parallel.h"
#include "surflux/radiosity/row_block.h"

namespace surflux {
namespace {

using shapes::add_rectangle;
using shapes::cube_inside;
using shapes::finish;
using shapes::scene_of;

// Plates that face each other, and a disk with its back to one: rays meet fronts, backs and nothing.
Scene plates() {
    Surfels s = shapes::disk({0.5, 0.5, 0.5}, {0, 0, 1}, 0.2);
    add_rectangle(s, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 8, 8);
    add_rectangle(s, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}, 8, 8);
    finish(s, 0.5, 0.0);
    return scene_of({s});
}

TEST(RowBlock, EveryRayIsCounted) {
    const Scene scene = scene_of({cube_inside(3, 0.5, 0.0)});
    const Tracer tracer(scene);
    const std::vector<Place> places = places_of(scene.surfels);
    std::vector<int> counts;
    for (std::size_t i = 0; i < places.size(); ++i) counts.push_back(16 << (i % 3));
    const RowBlock rows = gather_rows(scene, tracer, places, counts, 0);
    ASSERT_EQ(rows.size(), places.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
        EXPECT_EQ(rows.rays[i], static_cast<std::uint32_t>(counts[i]));
        EXPECT_EQ(rows.begin[i + 1] - rows.begin[i], rows.rays[i]);  // all meet a front in a closed room
        EXPECT_EQ(rows.into_backs[i] + rows.escaped(i), 0u);
        EXPECT_TRUE(std::is_sorted(rows.met.begin() + static_cast<std::ptrdiff_t>(rows.begin[i]),
                                   rows.met.begin() + static_cast<std::ptrdiff_t>(rows.begin[i + 1])));
    }
}

// A row does not know which others are made beside it, nor on how many threads.
TEST(RowBlock, RowsArePure) {
    const Scene scene = plates();
    const Tracer tracer(scene);
    const std::vector<Place> places = places_of(scene.surfels);
    const RowBlock all = gather_rows(scene, tracer, places, std::vector<int>(places.size(), 64), 7);
    std::size_t escaped = 0, into_backs = 0;
    for (std::size_t i = 0; i < places.size(); ++i) escaped += all.escaped(i), into_backs += all.into_backs[i];
    EXPECT_GT(std::min({escaped, into_backs, all.met.size()}), 100u);
    const ThreadLimit one(1);
    for (std::size_t i = 0; i < places.size(); i += 17) {
        const RowBlock alone = gather_rows(scene, tracer, {places[i]}, {64}, 7);
        const auto from = all.met.begin() + static_cast<std::ptrdiff_t>(all.begin[i]);
        const auto to = all.met.begin() + static_cast<std::ptrdiff_t>(all.begin[i + 1]);
        EXPECT_EQ(alone.met, std::vector<std::uint32_t>(from, to));
        EXPECT_EQ(alone.into_backs[0], all.into_backs[i]);
        EXPECT_EQ(alone.escaped(0), all.escaped(i));
    }
}

TEST(RowBlock, NoPlacesGiveNoRows) {
    const Scene scene = plates();
    const RowBlock rows = gather_rows(scene, Tracer(scene), {}, {}, 0);
    EXPECT_EQ(rows.size(), 0u);
    EXPECT_TRUE(rows.met.empty());
}

}  // namespace
}  // namespace surflux
