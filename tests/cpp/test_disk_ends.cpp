#include <gtest/gtest.h>

#include <algorithm>

#include "shapes.h"
#include "surflux/area/disk_ends.h"
#include "surflux/trace/tracer.h"

namespace surflux {
namespace {

constexpr int side = 8;
constexpr double spacing = 1.0 / side;

// side x side points at the centres of the cells of a square with that corner, facing along u x v.
void add_grid(Surfels& s, const Vec3& corner, const Vec3& u, const Vec3& v) {
    for (int a = 0; a < side; ++a)
        for (int b = 0; b < side; ++b) {
            s.positions.push_back(corner + spacing * ((a + 0.5) * u + (b + 0.5) * v));
            s.normals.push_back(cross(u, v));
        }
}

Surfels finished(Surfels s) {
    shapes::finish(s, 0.5, 0.0);
    s.radii = estimate_radii(s.positions);
    const DiskEnds found = find_disk_ends(s);
    s.ends = found.ends, s.alone = found.alone;
    return s;
}

Surfels square(const Vec3& corner, const Vec3& u, const Vec3& v) {
    Surfels s;
    add_grid(s, corner, u, v);
    return finished(std::move(s));
}

const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin;

TEST(DiskEnds, ASquareEndsABitOutsideOfItsOutermostPoints) {
    const Surfels s = square(origin, x, y);
    const std::vector<std::uint32_t> begin = end_ranges(s);
    for (std::uint32_t i = 0; i < s.size(); ++i) {
        const Vec3& p = s.positions[i];
        const int rims = (p.x < spacing) + (p.x > 1.0 - spacing) + (p.y < spacing) + (p.y > 1.0 - spacing);
        ASSERT_EQ(begin[i + 1] - begin[i], static_cast<std::uint32_t>(rims)) << i;
        for (std::uint32_t e = begin[i]; e < begin[i + 1]; ++e) {
            const DiskEnd& end = s.ends[e];
            EXPECT_EQ(end.kind, DiskEnd::border);
            EXPECT_EQ(end.surfel, i);
            // .05 of the mean distance of the six nearest, which is up to 1.5 spacings in a corner.
            EXPECT_GE(end.limit, 0.05 * spacing - 1e-12);
            EXPECT_LE(end.limit, 0.08 * spacing);
            EXPECT_GT(dot(end.normal, p - Vec3{0.5, 0.5, 0.0}), 0.4);  // outwards
            EXPECT_NEAR(length(end.normal), 1.0, 1e-12);
        }
    }
}

TEST(DiskEnds, ASphereHasNone) {
    Surfels s = shapes::sphere(500, 1.0, 1.0, 0.5, 0.0);
    const DiskEnds found = find_disk_ends(s);
    s.ends = found.ends, s.alone = found.alone;
    EXPECT_TRUE(s.ends.empty());
    EXPECT_TRUE(s.alone.empty());
}

TEST(DiskEnds, ADiskWithoutNeighboursStandsAlone) {
    Surfels s = square(origin, x, y);
    EXPECT_TRUE(s.alone.empty());
    s.positions.push_back({0.5, 0.5, 3.0});
    s.normals.push_back(z);
    s.radii.push_back(0.1);
    shapes::finish(s, 0.5, 0.0);
    const DiskEnds found = find_disk_ends(s);
    s.ends = found.ends, s.alone = found.alone;
    EXPECT_EQ(s.alone, std::vector<std::uint32_t>{side * side});
    EXPECT_EQ(select(s, {3, side * side, 4}).alone, std::vector<std::uint32_t>{1});
    EXPECT_EQ(shapes::scene_of({s, s}).surfels.alone, (std::vector<std::uint32_t>{side * side, 2 * side * side + 1}));
}

TEST(DiskEnds, TwoSquaresOfOneCloudEndAtTheirEdge) {
    Surfels s;
    add_grid(s, origin, x, y);      // the top of a box
    add_grid(s, {0, 0, -1}, z, y);  // its side at x = 0, facing -x
    s = finished(std::move(s));
    std::size_t creases = 0;
    for (const DiskEnd& end : s.ends) {
        if (end.kind != DiskEnd::crease) continue;
        ++creases;
        const Vec3& p = s.positions[end.surfel];
        // From half a cell to the edge and a little more.
        EXPECT_NEAR(end.limit, 0.5 * spacing + 0.02 * s.radii[end.surfel], 1e-9);
        EXPECT_NEAR(dot(end.normal, s.normals[end.surfel].z > 0.5 ? -1.0 * x : z), 1.0, 1e-9);
        EXPECT_LT(std::max(p.x, -p.z), spacing);
    }
    EXPECT_GE(creases, 2u * side);
}

TEST(DiskEnds, RaysFindTheSurfaceThatAreasCount) {
    const Surfels s = square(origin, x, y);
    const double past = 1.0 - 0.4 * spacing;  // beyond the outermost points, within their disks
    const auto down_at = [](const Tracer& tracer, double at) {
        std::vector<Hit> hits;
        tracer.closest({Ray{{{at, 0.5 + 0.5 * spacing, 1.0}, -1.0 * z, Hit::none}, -1.0 * z}}, hits);
        return hits[0];
    };
    ASSERT_GT(s.radii[0], 0.5 * spacing);
    {
        const Scene scene = shapes::scene_of({s});
        const Tracer tracer(scene);
        EXPECT_TRUE(down_at(tracer, 0.9).front);
        EXPECT_FALSE(down_at(tracer, past));
        EXPECT_FALSE(down_at(tracer, 0.4 * spacing));
        EXPECT_FALSE(down_at(tracer, 1.0 + spacing));
    }
    // Where another object adjoins, there is no border: a wall, or more floor.
    for (const Surfels& other : {square({1, 0, 0}, y, z), square({1, 0, 0}, x, y)}) {
        const Scene scene = shapes::scene_of({s, other});
        const Tracer tracer(scene);
        EXPECT_TRUE(down_at(tracer, past).front);
        EXPECT_FALSE(down_at(tracer, 0.4 * spacing).front);  // the other side is as it was
    }
}

TEST(DiskEnds, BeyondACreaseThereIsNothing) {
    Surfels s;
    add_grid(s, origin, x, y);
    add_grid(s, {0, 0, -1}, z, y);
    s = finished(std::move(s));
    const auto meets = [&](bool with_ends) {
        Surfels copy = s;
        if (!with_ends) copy.ends.clear();
        const Scene scene = shapes::scene_of({copy});
        const Tracer tracer(scene);
        std::vector<Hit> hits;
        // Past the edge, down along the side.
        tracer.closest({Ray{{{-0.1 * spacing, 0.5 + 0.5 * spacing, 1.0}, -1.0 * z, Hit::none}, -1.0 * z}}, hits);
        return bool(hits[0]);
    };
    EXPECT_TRUE(meets(false));
    EXPECT_FALSE(meets(true));
}

TEST(DiskEnds, GoWithTheirSurfels) {
    const Surfels s = square(origin, x, y);
    const Surfels chosen = select(s, {5, 0, 63});
    const std::vector<std::uint32_t> begin = end_ranges(chosen);
    EXPECT_EQ(begin, (std::vector<std::uint32_t>{0, 1, 3, 5}));
    const Scene scene = shapes::scene_of({s, s});
    ASSERT_EQ(scene.surfels.ends.size(), 2 * s.ends.size());
    EXPECT_EQ(scene.surfels.ends[s.ends.size()].surfel, s.ends[0].surfel + s.size());
}

}  // namespace
}  // namespace surflux
