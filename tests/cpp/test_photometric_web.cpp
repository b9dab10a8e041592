#include <gtest/gtest.h>

#include <cmath>

#include "surflux/core/sampling.h"
#include "surflux/lights/emitter.h"
#include "surflux/lights/photometric_web.h"
#include "surflux/lights/polygon.h"

using namespace surflux;

namespace {

PhotometricLight lamp(std::vector<double> planes, std::vector<double> angles, std::vector<double> table) {
    return {{0, 0, 0}, {0, 0, -1}, {1, 0, 0}, Rgb{1, 1, 1}, std::move(planes), std::move(angles), std::move(table)};
}

PhotometricLight uneven() {
    std::vector<double> planes, angles, table;
    for (int c = 0; c <= 360; c += 20) planes.push_back(c);
    for (int gamma = 0; gamma <= 180; gamma += 15) angles.push_back(gamma);
    for (const double c : planes)
        for (const double gamma : angles)
            table.push_back(2.0 + std::sin(c * pi / 180.0) * std::sin(gamma * pi / 180.0) +
                            std::cos(gamma * pi / 60.0));
    return lamp(planes, angles, table);
}

}  // namespace

TEST(PhotometricWeb, IsLinearBetweenPlanesAndAngles) {
    const PhotometricWeb web(lamp({0, 90, 180, 270, 360}, {0, 60, 90}, {1, 3, 0, 1, 5, 0, 1, 7, 0, 1, 9, 0, 1, 3, 0}));
    const auto at = [&](double c, double gamma) {
        c *= pi / 180.0, gamma *= pi / 180.0;
        return web.share(2.5 * Vec3{std::sin(gamma) * std::cos(c), std::sin(gamma) * std::sin(c), -std::cos(gamma)});
    };
    EXPECT_NEAR(at(0, 0), 1.0, 1e-12);
    EXPECT_NEAR(at(0, 30), 2.0, 1e-12);
    EXPECT_NEAR(at(45, 60), 4.0, 1e-12);
    EXPECT_NEAR(at(225, 30), 4.5, 1e-12);
    EXPECT_NEAR(at(315, 60), 6.0, 1e-12);
    EXPECT_NEAR(at(180, 75), 3.5, 1e-12);
    EXPECT_EQ(at(10, 90.001), 0.0);
    EXPECT_EQ(at(10, 180), 0.0);
}

TEST(PhotometricWeb, PowerIsTheIntegralOverAllDirections) {
    const PhotometricLight light = uneven();
    const PhotometricWeb web(light);
    double sum = 0.0;
    constexpr int rows = 720, turns = 720;
    for (int r = 0; r < rows; ++r)
        for (int t = 0; t < turns; ++t) {
            const double gamma = (r + 0.5) * pi / rows, c = (t + 0.5) * 2.0 * pi / turns;
            sum += web.share({std::sin(gamma) * std::cos(c), std::sin(gamma) * std::sin(c), -std::cos(gamma)}) *
                   std::sin(gamma) * (pi / rows) * (2.0 * pi / turns);
        }
    EXPECT_NEAR(web.power(), sum, 1e-4 * sum);
    EXPECT_NEAR(PhotometricWeb(lamp({0, 360}, {0, 180}, {1, 1, 1, 1})).power(), 4.0 * pi, 1e-12);
}

TEST(PhotometricWeb, TrianglesAllAroundHaveItsPower) {
    const PhotometricWeb web(uneven());
    const Vec3 corners[4] = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
    const Vec3 place{0.1, -0.2, 0.15};
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) sum += web.power(place, {corners[k], corners[(k + 1) % 4], corners[(k + 2) % 4], 0});
    EXPECT_NEAR(sum, web.power(), 2e-3 * web.power());
}

TEST(PhotometricWeb, PlacesInTheirPlaneOrOnACornerSeeNothing) {
    const PhotometricWeb web(uneven());
    const Triangle t{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0};
    EXPECT_EQ(web.power(t.a, t), 0.0);
    EXPECT_NEAR(web.power({-1, -1, 0}, t), 0.0, 1e-12);
}

TEST(PhotometricWeb, RaysStandForItsPower) {
    const PhotometricWeb web(uneven());
    const PhotometricWeb::Rays rays(web);
    constexpr int side = 512;
    double sum = 0.0, up = 0.0;
    for (int a = 0; a < side; ++a)
        for (int b = 0; b < side; ++b) {
            const auto [d, power] = rays.draw((a + 0.5) / side, (b + 0.5) / side);
            EXPECT_NEAR(length(d), 1.0, 1e-12);
            sum += power;
            if (d.y > 0.0) up += power;
        }
    EXPECT_NEAR(sum / (side * side) * 2.0 * pi, web.power(), 2e-3 * web.power());
    // More to +y: the integral of sin(c) sin(gamma) over that half is pi.
    EXPECT_NEAR(up / sum, 0.5 + pi / web.power(), 0.01);
}

TEST(PhotometricWeb, ABeamHasTheAngleOfAConeOfItsPower) {
    std::vector<double> table;
    for (int p = 0; p < 2; ++p) table.insert(table.end(), {4.0, 4.0});
    EXPECT_NEAR(PhotometricWeb(lamp({0, 360}, {0, 10}, table)).beam(), 10.0 * pi / 180.0, 1e-9);
    EXPECT_NEAR(PhotometricWeb(lamp({0, 360}, {0, 180}, table)).beam(), pi, 1e-6);
    EXPECT_EQ(PhotometricWeb(lamp({0, 360}, {0, 180}, {0, 0, 0, 0})).beam(), 0.0);
}
