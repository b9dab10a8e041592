#include <gtest/gtest.h>

#include <cmath>

#include "surflux/core/sampling.h"
#include "surflux/radiosity/polygon_exchange.h"

namespace surflux {
namespace {

Polygon rectangle(const Vec3& corner, const Vec3& u, const Vec3& v) {
    return {corner, corner + u, corner + u + v, corner + v};
}

TEST(PolygonExchange, OfTheFacesOfACube) {
    const Polygon floor = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const Polygon ceiling = rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0});
    const Polygon wall = rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1});
    EXPECT_NEAR(polygon_exchange(floor, ceiling, 12), 0.1998248957, 1e-10);
    EXPECT_NEAR(polygon_exchange(floor, wall, 16), 0.2000437761, 2e-8);
    EXPECT_NEAR(polygon_exchange(wall, floor, 16), 0.2000437761, 2e-8);
}

TEST(PolygonExchange, SteepPointsArePreciseWhereEdgesTouchAndPlainOnesFarOff) {
    // Opposite and adjacent faces of a cube (Howell, configurations C-11 and C-14), to all digits.
    const double opposite =
        2.0 / pi * (0.5 * std::log(4.0 / 3.0) + 2.0 * std::sqrt(2.0) * std::atan(std::sqrt(0.5)) - pi / 2.0);
    const Polygon floor = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const Polygon wall = rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1});
    const Polygon ceiling = rectangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0});
    EXPECT_NEAR(polygon_exchange(floor, wall, 24, Grading::steep), (1.0 - opposite) / 4.0, 1e-14);
    EXPECT_NEAR(polygon_exchange(floor, ceiling, 24, Grading::steep), opposite, 1e-14);
    EXPECT_NEAR(polygon_exchange(floor, ceiling, 10, Grading::plain), opposite, 1e-14);
    const Polygon far = rectangle({-7, 0, 0}, {0, 1, 0}, {0, 0, 1});
    const double precise = polygon_exchange(floor, far, 32, Grading::steep);
    EXPECT_NEAR(polygon_exchange(floor, far, 4, Grading::plain), precise, 1e-10 * precise);
}

TEST(PolygonExchange, OfParallelRectangles) {
    EXPECT_NEAR(
        polygon_exchange(rectangle({0, 0, 0}, {1, 0, 0}, {0, 2, 0}), rectangle({0, 0, 0.5}, {0, 2, 0}, {1, 0, 0}), 16) /
            2.0,
        0.5089886690, 1e-9);
}

}  // namespace
}  // namespace surflux
