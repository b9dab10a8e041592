#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

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

TEST(PolygonExchange, OfEdgesThatTouchInPart) {
    // The same as of the pieces into which corners of the other cut it, whose edges touch wholly or in a corner.
    const auto floor = [](double from, double to) { return rectangle({0, from, 0}, {1, 0, 0}, {0, to - from, 0}); };
    for (const auto& [low, high] : {std::pair{0.3, 0.8}, std::pair{0.3, 1.4}, std::pair{0.0, 0.5}}) {
        const Polygon wall = rectangle({0, low, 0}, {0, high - low, 0}, {0, 0, 1});
        double wanted = 0.0, from = 0.0;
        for (const double to : {low, std::min(high, 1.0), 1.0}) {
            if (to > from) wanted += polygon_exchange(floor(from, to), wall, 32, Grading::steep);
            from = to;
        }
        EXPECT_NEAR(polygon_exchange(floor(0, 1), wall, 32, Grading::steep), wanted, 1e-14);
        EXPECT_NEAR(polygon_exchange(wall, floor(0, 1), 32, Grading::steep), wanted, 1e-14);
        EXPECT_NEAR(polygon_exchange(floor(0, 1), wall, 12), wanted, 1e-7);
    }
}

TEST(PolygonExchange, OfEdgesThatCross) {
    // A wall over a floor's edge, askew: of it, and of the halves of the floor on its front.
    const double c = std::cos(0.4), s = std::sin(0.4);
    const Polygon wall = rectangle({0.5 - c, -s, 0}, {2 * c, 2 * s, 0}, {0, 0, 1});
    Polygon floor;
    clip_to_front(rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), {0.5, 0, 0}, {s, -c, 0}, floor);
    double wanted = 0.0;
    for (const double x : {0.5, 0.75, 1.0}) {  // strips of it
        Polygon left, strip;
        clip_to_front(floor, {x, 0, 0}, {-1, 0, 0}, left);
        clip_to_front(left, {x - 0.25, 0, 0}, {1, 0, 0}, strip);
        if (strip.size() > 2) wanted += polygon_exchange(strip, wall, 32, Grading::steep);
    }
    EXPECT_NEAR(polygon_exchange(floor, wall, 32, Grading::steep), wanted, 1e-12);
}

TEST(PolygonExchange, OfParallelRectangles) {
    EXPECT_NEAR(
        polygon_exchange(rectangle({0, 0, 0}, {1, 0, 0}, {0, 2, 0}), rectangle({0, 0, 0.5}, {0, 2, 0}, {1, 0, 0}), 16) /
            2.0,
        0.5089886690, 1e-9);
}

}  // namespace
}  // namespace surflux
