#include <gtest/gtest.h>

#include "refusal.h"
#include "shapes.h"
#include "surflux/area/effective_area.h"

namespace surflux {
namespace {

// As the corners of a mesh with hard edges are stored: once for each face, at the same place.
TEST(EffectiveArea, IsHalfOnAnEdgeAndAQuarterInACorner) {
    constexpr int n = 10;
    Surfels s;
    for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n; ++j) {
                Vec3 p, normal;
                p[(axis + 1) % 3] = i;
                p[(axis + 2) % 3] = j;
                normal[axis] = -1.0;
                s.positions.push_back(p);
                s.normals.push_back(normal);
            }
    for (const double side : {1.0, -1.0}) {  // of the corner of a box, and of a room
        for (Vec3& normal : s.normals) normal *= side;
        shapes::finish(s, 0.5, 0.0);
        s.radii.assign(s.size(), 0.78);
        const std::vector<double> areas = effective_areas(s, {});
        EXPECT_NEAR(areas[5 * (n + 1) + 5], 1.0, 0.01);
        EXPECT_NEAR(areas[5], 0.5, 0.01);
        EXPECT_NEAR(areas[0], 0.25, 0.01);
    }
}

// One half of a floor lies three spacings higher: each half has a border of its own there.
TEST(EffectiveArea, EndsWhereAnotherLayerBegins) {
    Surfels s;
    for (int x = 0; x < 20; ++x)
        for (int y = 0; y < 10; ++y) {
            s.positions.push_back({double(x), double(y), x < 10 ? 0.0 : 3.0});
            s.normals.push_back({0, 0, 1});
        }
    shapes::finish(s, 0.5, 0.0);
    s.radii.assign(s.size(), 2.0);
    const std::vector<double> areas = effective_areas(s, {});
    for (int x : {9, 10}) EXPECT_NEAR(areas[static_cast<std::size_t>(x) * 10 + 5], areas[5], 1e-3) << x;
}

TEST(EffectiveArea, OfADiskWithoutExtentIsZeroAndOfNoneButSuchIsRefused) {
    Surfels s = select(shapes::disk({0, 0, 0}, {0, 0, 1}, 1e-200), {0, 0, 0});  // squared, that is 0
    EXPECT_EQ(refusal([&] { effective_areas(s, {}); }).find("radii: the largest is 1e-200, wanted between"), 0u);
    s.positions[2] = {0, 0, 5};
    s.radii[2] = 1.0;
    const std::vector<double> areas = effective_areas(s, {});
    EXPECT_EQ(areas[0], 0.0);
    EXPECT_EQ(areas[1], 0.0);
    EXPECT_NEAR(areas[2], pi, 1e-6);
}

}  // namespace
}  // namespace surflux
