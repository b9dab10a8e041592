#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "splat_pictures.h"

#include "surflux/core/sampling.h"
#include "surflux/render/kernel_walls.h"

namespace surflux {
namespace {

// A patch of a floor around the origin, and a wall of many faces at a distance from it, from one end to the other.
struct Room {
    Surfels surfels;
    Frame axes;

    Room(double angle, double distance, double from, double to, int faces) : axes(frame_around({0, 0, 1})) {
        add_square(surfels, {-0.5, -0.5, 0}, {1, 0, 0}, {0, 1, 0}, 1);
        const Vec3 out{std::cos(angle), std::sin(angle), 0}, along{-out.y, out.x, 0};
        for (int k = 0; k < faces; ++k) {
            const double step = (to - from) / faces;
            add_square(surfels, distance * out + (from + k * step) * along, step * along, {0, 0, 0.5}, 1);
        }
    }
    bool is_behind(const KernelWalls& walls, const Vec3& p) const {
        const auto [begin, end] = walls.of(0);
        return surflux::is_behind(begin, end, static_cast<float>(dot(p, axes.u)), static_cast<float>(dot(p, axes.v)));
    }
};

// Does the way from the origin to p cross the wall?
TEST(KernelWalls, HideWhatIsBehind) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> number(0.0, 1.0);
    for (int k = 0; k < 60; ++k) {
        const double angle = k % 8 < 4 ? 0.5 * pi * (k % 4) : 2.0 * pi * number(random);
        const double distance = 0.02 + 0.9 * number(random);
        const Room room(angle, distance, -5.0, 5.0, k % 3 == 0 ? 1 : 41);
        const KernelWalls walls(room.surfels, 1.5);
        for (int n = 0; n < 200; ++n) {
            const Vec3 p{2.0 * number(random) - 1.0, 2.0 * number(random) - 1.0, 0.0};
            const double beyond = p.x * std::cos(angle) + p.y * std::sin(angle) - distance;
            if (std::abs(beyond) < 1e-3) continue;
            ASSERT_EQ(room.is_behind(walls, p), beyond > 0.0) << k << " " << p.x << " " << p.y;
        }
    }
}

// Ends of walls are told to a half of a 64th of the circle.
TEST(KernelWalls, EndWhereWallsEnd) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> number(0.0, 1.0);
    std::size_t hidden = 0;
    for (int k = 0; k < 40; ++k) {
        const double angle = 2.0 * pi * number(random), distance = 0.1 + 0.3 * number(random);
        const Room room(angle, distance, -0.2, 0.3, 1 + k % 5);
        const KernelWalls walls(room.surfels, 1.5);
        for (int n = 0; n < 200; ++n) {
            const Vec3 p{2.0 * number(random) - 1.0, 2.0 * number(random) - 1.0, 0.0};
            const double out = p.x * std::cos(angle) + p.y * std::sin(angle);
            const double turned = std::atan2(p.y * std::cos(angle) - p.x * std::sin(angle), out);
            const double low = std::atan2(-0.2, distance), high = std::atan2(0.3, distance), half = pi / 64 + 2e-3;
            if (std::abs(turned - low) < half || std::abs(turned - high) < half || std::abs(out - distance) < 1e-3)
                continue;
            const bool behind = out > distance && turned > low && turned < high;
            ASSERT_EQ(room.is_behind(walls, p), behind) << k << " " << p.x << " " << p.y;
            hidden += behind;
        }
    }
    EXPECT_GT(hidden, 500u);
}

// Nothing is seen through a round tower, whose facets are finer than the patches of the floor around it.
TEST(KernelWalls, HideWhatIsBehindATower) {
    for (const int facets : {64, 256, 2048}) {
        Surfels s;
        add_square(s, {-0.5, -0.5, 0}, {1, 0, 0}, {0, 1, 0}, 1);
        constexpr double distance = 0.3, radius = 6.0;
        const Vec3 middle{distance + radius, 0, 0};
        const auto corner = [&](int k) {
            const double angle = 2.0 * pi * k / facets;
            return middle + radius * Vec3{std::cos(angle), std::sin(angle), 0};
        };
        for (int k = 0; k < facets; ++k) add_square(s, corner(k), corner(k + 1) - corner(k), {0, 0, 1}, 1);
        const KernelWalls walls(s, 1.5);
        const auto [begin, end] = walls.of(0);
        const Frame axes = frame_around({0, 0, 1});
        std::mt19937 random(3);
        std::uniform_real_distribution<double> number(-1.5, 1.5);
        std::size_t inside = 0;
        for (int n = 0; n < 5000; ++n) {
            const Vec3 p{number(random), number(random), 0};
            const double deep = radius - length(p - middle), on_way = p.x > 0.0 ? std::abs(p.y / p.x) : 2.0;
            if (deep < 0.03 || on_way > 1.0) continue;
            ASSERT_TRUE(is_behind(begin, end, static_cast<float>(dot(p, axes.u)), static_cast<float>(dot(p, axes.v))))
                << facets << " " << p.x << " " << p.y;
            ++inside;
        }
        EXPECT_GT(inside, 500u);
    }
}

// Within a tent the light of the ground outside is hidden, whether its cloth has one side or two.
TEST(KernelWalls, HideWhatIsOutsideOfATent) {
    for (const double slope : {35.0, 50.0, 70.0})
        for (const bool both : {false, true}) {
            Surfels s;
            add_square(s, {-0.5, -0.5, 0}, {1, 0, 0}, {0, 1, 0}, 1);
            const double angle = slope * pi / 180.0;
            const Vec3 foot{0.6, -3, 0}, up{-2 * std::cos(angle), 0, 2 * std::sin(angle)}, along{0, 6, 0};
            add_square(s, foot, up, along, 1);  // its normal points down and inwards
            if (both) add_square(s, foot, along, up, 1);
            const KernelWalls walls(s, 1.5);
            EXPECT_EQ(walls.of(0).second - walls.of(0).first, 1) << slope << both;
        }
}

// What stands less steeply blends: the inside of a ball of patches has no walls, nor has its outside, nor have both
// sides of a sheet.
TEST(KernelWalls, AreNotInABowl) {
    Surfels ball;
    for (const double side : {1.0, -1.0}) {
        constexpr int rings = 16, sectors = 32;
        const auto at = [&](int i, int j) {
            const double t = pi * i / rings, phi = side * 2.0 * pi * j / sectors;
            return Vec3{std::sin(t) * std::cos(phi), std::sin(t) * std::sin(phi), std::cos(t)};
        };
        for (int i = 1; i + 1 < rings; ++i)
            for (int j = 0; j < sectors; ++j) {
                const Vec3 corner = at(i, j);
                add_square(ball, corner, at(i + 1, j) - corner, at(i, j + 1) - corner, 1);
            }
        EXPECT_EQ(KernelWalls(ball, 1.5).size(), 0u) << side;
    }
}

TEST(KernelWalls, OfNoSurfelsAreNone) { EXPECT_EQ(KernelWalls(Surfels{}, 1.5).size(), 0u); }

}  // namespace
}  // namespace surflux
