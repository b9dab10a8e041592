#include "surflux/radiosity/normal_field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shapes.h"

namespace surflux {
namespace {

// A sheet that is bent like a roof's gutter, radius 1 about the y axis: normals turn along x alone.
Vec3 normal_at(double x) { return {std::sin(x), 0.0, std::cos(x)}; }

NormalField gutter(double spacing) {
    std::vector<Vec3> positions, normals;
    for (int a = -10; a <= 10; ++a)
        for (int b = -10; b <= 10; ++b) {
            const double x = a * spacing;
            positions.push_back({std::sin(x), b * spacing, std::cos(x)});
            normals.push_back(normal_at(x));
        }
    std::vector<std::uint32_t> objects(positions.size(), 3);
    return {positions, normals, objects};
}

TEST(NormalField, TurnsWithTheSurface) {
    // The mean of the two nearest at a quarter of the way between them is off by up to a quarter of the angle; to first
    // order by the square of the spacing. What is stiff in fitted slopes leaves a tenth of a turn of half a spacing.
    for (const double spacing : {0.1, 0.05}) {
        const NormalField field = gutter(spacing);
        for (const double share : {0.1, 0.25, 0.5, 0.75}) {
            const double x = share * spacing;
            const Vec3 found = field.at({std::sin(x), 0.3 * spacing, std::cos(x)}, {0, 0, 1}, 3);
            EXPECT_NEAR(length(found), 1.0, 1e-12);
            EXPECT_LT(length(cross(found, normal_at(x))), 0.01 * spacing + spacing * spacing) << share;
        }
    }
}

TEST(NormalField, PointsKeepTheirOwnAndNothingIsInventedWhereNoneFaces) {
    const NormalField field = gutter(0.1);
    EXPECT_LT(length(field.at({0, 0, 1}, {0, 0, 1}, 3) - Vec3{0, 0, 1}), 1e-9);
    const Vec3 away{0, 0, -1};
    EXPECT_EQ(field.at({0, 0, 1}, away, 3), away);
}

}  // namespace
}  // namespace surflux
