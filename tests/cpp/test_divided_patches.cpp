#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/scene/divided_patches.h"

namespace surflux {
namespace {

void add(FlatPolygons& to, const std::vector<Vec3>& corners) {
    to.corners.insert(to.corners.end(), corners.begin(), corners.end());
    to.begin.push_back(to.corners.size());
}

std::vector<Vec3> rectangle(const Vec3& corner, const Vec3& u, const Vec3& v) {
    return {corner, corner + u, corner + u + v, corner + v};
}

const std::vector<Vec3> square = rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});  // seen from above

double area_of(const Vec3* corners, std::size_t count) {
    Vec3 sum;
    for (std::size_t k = 2; k < count; ++k) sum += cross(corners[k - 1] - corners[0], corners[k] - corners[0]);
    return 0.5 * length(sum);
}

std::vector<double> areas_of(const FlatPolygons& polygons) {
    std::vector<double> out;
    for (std::size_t p = 0; p < polygons.size(); ++p) out.push_back(area_of(polygons.of(p), polygons.count(p)));
    return out;
}

std::vector<double> parts_of_square(const std::vector<std::vector<Vec3>>& walls) {
    FlatPolygons patches, all;
    add(patches, square);
    for (const auto& wall : walls) add(all, wall);
    std::vector<double> out = areas_of(divide_patches(patches, all).pieces);
    std::sort(out.begin(), out.end());
    return out;
}

TEST(DividedPatches, EndAtAWall) {
    const auto parts = parts_of_square({rectangle({0.3, -1, 0}, {0, 3, 0}, {0, 0, 2})});
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_NEAR(parts[0], 0.3, 1e-12);
    EXPECT_NEAR(parts[1], 0.7, 1e-12);
    // From below up through the patch, and turned the other way.
    EXPECT_EQ(parts_of_square({rectangle({0.3, -1, -1}, {0, 0, 2}, {0, 3, 0})}).size(), 2u);
}

TEST(DividedPatches, KeepTheirCorners) {
    const Vec3 far{5e6, -4e6, 100};
    FlatPolygons patches, walls;
    add(patches, rectangle(far, {1.1, 0, 0}, {0, 1.3, 0}));
    add(walls, rectangle(far + Vec3{0.3, -1, 0}, {0, 3, 0}, {0, 0, 2}));
    const DividedPatches found = divide_patches(patches, walls);
    ASSERT_EQ(found.patch, (std::vector<std::uint32_t>{0, 0}));
    for (std::size_t k = 0; k < 4; ++k) {
        const auto same = [&](const Vec3& p) { return p == patches.corners[k]; };
        EXPECT_EQ(std::count_if(found.pieces.corners.begin(), found.pieces.corners.end(), same), 1);
    }
    EXPECT_NEAR(areas_of(found.pieces)[0] + areas_of(found.pieces)[1], 1.1 * 1.3, 1e-8);  // 5e6 has 1e-9 behind it
}

TEST(DividedPatches, AreWholeWhereNoWallStands) {
    const auto wall = [](double x, double from, double to, double low, double high) {
        return rectangle({x, from, low}, {0, to - from, 0}, {0, 0, high - low});
    };
    EXPECT_EQ(parts_of_square({wall(0.5, -1, 2, -1, 0)}).size(), 0u) << "behind it";
    EXPECT_EQ(parts_of_square({wall(0.5, -1, 2, 0.1, 2)}).size(), 0u) << "over it";
    EXPECT_EQ(parts_of_square({wall(0.0, -1, 2, 0, 2), wall(1, -1, 2, 0, 2)}).size(), 0u) << "along its edges";
    EXPECT_EQ(parts_of_square({wall(0.5, -1, -0.1, 0, 2)}).size(), 0u) << "beside it";
    EXPECT_EQ(parts_of_square({wall(0.5, 0.3, 0.7, 0, 2)}).size(), 0u) << "light goes round what is short";
    EXPECT_EQ(parts_of_square({wall(0.5, -1, 0.6, 0, 2)}).size(), 2u) << "over more than half of its width";
    EXPECT_EQ(parts_of_square({wall(0.5, -1, 2, 0.01, 2)}).size(), 2u) << "over a slit";
    // A ramp of 1 in 10, which starts in the middle.
    EXPECT_EQ(parts_of_square({rectangle({0.5, -1, 0}, {10, 0, 1}, {0, 3, 0})}).size(), 0u) << "relief";
}

// From the corner of the square to (x, y), with fronts towards it or, as a solid has them, away from it.
std::vector<std::vector<Vec3>> corner_of_a_house(double x, double y, bool inward, double gap = 0.0) {
    std::vector<std::vector<Vec3>> out{rectangle({x, -1, 0}, {0, 1 + y - gap, 0}, {0, 0, 2}),
                                       rectangle({x, y, 0}, {-1 - x, 0, 0}, {0, 0, 2})};
    for (auto& wall : out)
        if (inward) std::reverse(wall.begin(), wall.end());
    return out;
}

TEST(DividedPatches, EndWhereWallsCloseOffAPartTogether) {
    for (const double x : {0.25, 0.1, 0.04}) {
        const auto parts = parts_of_square(corner_of_a_house(x, 0.25, true));
        ASSERT_EQ(parts.size(), 3u) << x;
        EXPECT_NEAR(parts[0], 0.25 * x, 1e-12);
        EXPECT_EQ(parts_of_square(corner_of_a_house(x, 0.2, false)).size(), 0u) << "in a solid it is dark";
        auto sheets = corner_of_a_house(x, 0.2, false);
        for (const auto& wall : corner_of_a_house(x, 0.2, true)) sheets.push_back(wall);
        EXPECT_EQ(parts_of_square(sheets).size(), 3u);
        EXPECT_EQ(parts_of_square(corner_of_a_house(x, 0.2, true, 0.08)).size(), 0u) << "light goes through a door";
        EXPECT_EQ(parts_of_square(corner_of_a_house(x, 5e-4 / x, true)).size(), 0u) << "too little";
    }
    // A house in the middle.
    std::vector<std::vector<Vec3>> house;
    const Vec3 corners[] = {{0.3, 0.4, 0}, {0.37, 0.4, 0}, {0.37, 0.45, 0}, {0.3, 0.45, 0}};
    for (int k = 0; k < 4; ++k) house.push_back(rectangle(corners[k], {0, 0, 1}, corners[(k + 1) % 4] - corners[k]));
    const auto parts = parts_of_square(house);
    ASSERT_EQ(parts.size(), 5u);
    EXPECT_NEAR(parts[0], 0.07 * 0.05, 1e-12);
}

TEST(DividedPatches, AreDividedOnceByFacesOfOneWall) {
    Random random(1, 0);
    std::vector<std::vector<Vec3>> faces;
    for (int k = 0; k < 40; ++k)
        for (int side = 0; side < 2; ++side) {
            const double a = 0.05 * k - 0.5, b = a + 0.05, shift = 1e-9 * random.uniform();
            const Vec3 p{0.4 + shift, a, 0}, q{0.4 + shift, b, 0}, r{0.4, b, 0.05}, s{0.4, a, 0.05};
            faces.push_back(side ? std::vector<Vec3>{p, q, r} : std::vector<Vec3>{p, r, s});
        }
    const auto parts = parts_of_square(faces);
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_NEAR(parts[0], 0.4, 1e-8);
}

TEST(DividedPatches, HaveNoStripBetweenSheetsOfOneWall) {
    const auto wall = [](double x, double from, double to) {
        return rectangle({x, from, 0}, {0, to - from, 0}, {0, 0, 2});
    };
    const auto parts = parts_of_square({wall(0.4, -1, 2), wall(0.405, -1, 2)});
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_NEAR(parts[0], 0.4, 0.005 + 1e-12);
    EXPECT_EQ(parts_of_square({wall(0.4, -1, 2), wall(0.43, -1, 2)}).size(), 3u) << "wide enough to be seen";
    // Walls that go on from each other beside each other are two.
    EXPECT_EQ(parts_of_square({wall(0.4, -1, 0.5), wall(0.405, 0.5, 2)}).size(), 3u);
}

TEST(DividedPatches, AreCutAroundAColumn) {
    std::vector<std::vector<Vec3>> sides;
    constexpr int n = 12;
    for (int k = 0; k < n; ++k) {
        const auto at = [](int i) {
            return Vec3{0.5 + 0.2 * std::cos(2 * pi * i / n), 0.5 + 0.2 * std::sin(2 * pi * i / n), 0};
        };
        sides.push_back(rectangle(at(k), at(k + 1) - at(k), {0, 0, 1}));
    }
    const auto parts = parts_of_square(sides);
    EXPECT_EQ(parts.size(), n + 1u);
    const double within = 0.5 * n * 0.04 * std::sin(2 * pi / n);
    EXPECT_TRUE(std::any_of(parts.begin(), parts.end(), [&](double a) { return std::abs(a - within) < 1e-12; }));
}

// n triangles in a box of side 1, of which each goes through many others, and a large one through all.
FlatPolygons soup(int n) {
    Random random(7, 0);
    const auto drawn = [&] { return Vec3{random.uniform(), random.uniform(), random.uniform()}; };
    FlatPolygons out;
    add(out, {{-1, -1, 0.5}, {3, -1, 0.5}, {-1, 3, 0.5}});
    for (int k = 0; k < n; ++k) {
        const Vec3 a = drawn();
        add(out, {a, a + drawn() - Vec3{0.5, 0.5, 0.5}, a + drawn() - Vec3{0.5, 0.5, 0.5}});
    }
    return out;
}

TEST(DividedPatches, OfASoupAreBounded) {
    const FlatPolygons faces = soup(2000);
    DivisionOptions options;
    options.most_added = 5000;
    const DividedPatches found = divide_patches(faces, faces, {}, options);
    const std::vector<double> whole = areas_of(faces), parts = areas_of(found.pieces);
    std::vector<double> sum(faces.size(), 0.0);
    std::vector<std::size_t> count(faces.size(), 0);
    for (std::size_t k = 0; k < parts.size(); ++k) {
        sum[found.patch[k]] += parts[k];
        ++count[found.patch[k]];
        EXPECT_GE(parts[k], 0.999 * options.least_share * whole[found.patch[k]]);
    }
    EXPECT_EQ(count[0], options.most_pieces);
    std::size_t added = 0;
    for (std::size_t p = 0; p < faces.size(); ++p) {
        if (count[p] == 0) continue;
        added += count[p] - 1;
        EXPECT_LE(count[p], options.most_pieces);
        EXPECT_NEAR(sum[p], whole[p], 1e-12 * whole[p] * static_cast<double>(count[p]) + 1e-15);
    }
    EXPECT_LE(added, options.most_added);
    EXPECT_GT(added, options.most_added - options.most_pieces);
}

TEST(DividedPatches, AreTheSameForAnyNumberOfThreads) {
    const FlatPolygons faces = soup(300);
    const DividedPatches all = divide_patches(faces, faces);
    const ThreadLimit one(1);
    const DividedPatches alone = divide_patches(faces, faces);
    EXPECT_EQ(all.patch, alone.patch);
    EXPECT_TRUE(all.pieces.corners == alone.pieces.corners);
}

TEST(DividedPatches, CanBeCancelled) {
    const FlatPolygons faces = soup(300);
    EXPECT_THROW(divide_patches(faces, faces, [](std::size_t, std::size_t) { return false; }), Cancelled);
}

}  // namespace
}  // namespace surflux
