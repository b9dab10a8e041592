#include <gtest/gtest.h>

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

TEST(PolygonExchange, OfParallelRectangles) {
    EXPECT_NEAR(
        polygon_exchange(rectangle({0, 0, 0}, {1, 0, 0}, {0, 2, 0}), rectangle({0, 0, 0.5}, {0, 2, 0}, {1, 0, 0}), 16) /
            2.0,
        0.5089886690, 1e-9);
}

}  // namespace
}  // namespace surflux
