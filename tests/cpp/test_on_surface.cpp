#include "surflux/neighbors/on_surface.h"

#include <gtest/gtest.h>

#include <cmath>

namespace surflux {
namespace {

// A plate of 20 x 20 disks that leave no gap, half the diagonal of a cell wide, beside a disk as large as the plate.
struct Plate {
    std::vector<Vec3> centers, normals;
    std::vector<double> radii;
    Plate() {
        for (int i = 0; i < 20; ++i)
            for (int j = 0; j < 20; ++j) add({i + 0.5, j + 0.5, 0.0}, std::sqrt(0.5));
        add({50.0, 10.0, 0.0}, 20.0);
    }
    void add(const Vec3& center, double radius) {
        centers.push_back(center), normals.push_back({0, 0, 1}), radii.push_back(radius);
    }
    bool on(const Vec3& point, const Vec3& normal) const {
        return OnSurface(centers, normals, radii)({point}, {normal})[0] != 0;
    }
};

TEST(OnSurface, ReachesAsFarAsDisksOfTheirOwnSize) {
    const Plate plate;
    const Vec3 up{0, 0, 1};
    const double r = std::sqrt(0.5);
    EXPECT_TRUE(plate.on({7.3, 9.1, 0.0}, up));
    EXPECT_TRUE(plate.on({7.3, 9.1, 0.99 * r}, up));
    EXPECT_FALSE(plate.on({7.3, 9.1, 1.01 * r}, up));
    EXPECT_TRUE(plate.on({0.5 - 1.99 * r, 9.5, 0.0}, up));
    EXPECT_FALSE(plate.on({0.5 - 2.01 * r, 9.5, 0.0}, up));
    // The large disk has the say around itself, and none over the plate.
    EXPECT_TRUE(plate.on({50.0, 10.0, 10.0}, up));
    EXPECT_FALSE(plate.on({7.3, 9.1, 10.0}, up));
}

TEST(OnSurface, ReachesTheCornersOfLongPatches) {
    const std::vector<Vec3> centers{{0, 0, 0}}, up{{0, 0, 1}};
    const std::vector<double> radii{1.0};
    const auto on = [&](const OnSurface& surface, const Vec3& point) { return surface({point}, up)[0] != 0; };
    const OnSurface disk(centers, up, radii), patch(centers, up, radii, {5.0});
    EXPECT_FALSE(on(disk, {4, 3, 0}));
    EXPECT_TRUE(on(patch, {4, 3, 0}));
    EXPECT_TRUE(on(patch, {4, 2.9, 0.99}));
    EXPECT_FALSE(on(patch, {4, 3.1, 0}));
    EXPECT_FALSE(on(patch, {4, 2.9, 1.01}));
    // What is nearer to a centre than corners are does not make a disk smaller.
    EXPECT_TRUE(on(OnSurface(centers, up, radii, {0.5}), {1.9, 0, 0}));
}

TEST(OnSurface, HasAFront) {
    const Plate plate;
    EXPECT_TRUE(plate.on({7.3, 9.1, 0.0}, {std::sqrt(0.75), 0, 0.5}));
    EXPECT_FALSE(plate.on({7.3, 9.1, 0.0}, {0, 0, -1}));
}

}  // namespace
}  // namespace surflux
