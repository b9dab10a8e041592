#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "surflux/core/sampling.h"
#include "surflux/scene/patch_cells.h"

namespace surflux {
namespace {

double area_of_all(const std::vector<Triangle>& triangles) {
    double sum = 0.0;
    for (const Triangle& t : triangles) sum += area_of(t);
    return sum;
}

bool holds(const Triangle& t, const Vec3& p) {
    const Vec3 n = cross_of(t);
    return dot(cross(t.b - t.a, p - t.a), n) > 0.0 && dot(cross(t.c - t.b, p - t.b), n) > 0.0 &&
           dot(cross(t.a - t.c, p - t.c), n) > 0.0;
}

Vec3 drawn_from(const Triangle& t, Random& random) {
    const double root = std::sqrt(random.uniform()), v = random.uniform();
    return (1.0 - root) * t.a + (root * (1.0 - v)) * t.b + (root * v) * t.c;
}

// That the cells are a partition by nearest point: areas add up, each is turned as the patch, and a random place of the
// patch lies in the cell of the point nearest to it and in no other.
void expect_partition(const std::vector<Triangle>& patch, const std::vector<Vec3>& points) {
    const auto cells = patch_cells(patch.data(), patch.data() + patch.size(), points.data(), points.size());
    ASSERT_EQ(cells.size(), points.size());
    double sum = 0.0;
    for (const auto& cell : cells) {
        sum += area_of_all(cell);
        for (const Triangle& t : cell) {
            EXPECT_EQ(t.surfel, patch[0].surfel);
            if (area_of(t) > 1e-12) {
                EXPECT_GT(dot(cross_of(t), cross_of(patch[0])), 0.0);
            }
        }
    }
    EXPECT_NEAR(sum, area_of_all(patch), 1e-12 * area_of_all(patch));
    Random random(1, 0);
    for (int k = 0; k < 2000; ++k) {
        const Vec3 p = drawn_from(patch[static_cast<std::size_t>(k) % patch.size()], random);
        std::size_t nearest = 0;
        for (std::size_t i = 1; i < points.size(); ++i)
            if (length_squared(points[i] - p) < length_squared(points[nearest] - p)) nearest = i;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const bool inside =
                std::any_of(cells[i].begin(), cells[i].end(), [&](const Triangle& t) { return holds(t, p); });
            if (i != nearest) {
                ASSERT_FALSE(inside) << k;
                continue;
            }
            // Or it stands on the border between two of its triangles, which rounding puts in neither.
            double least = 1e300;
            for (const Triangle& t : cells[i])
                for (const auto& [a, b] : {std::pair{t.a, t.b}, {t.b, t.c}, {t.c, t.a}})
                    least = std::min(least, length(cross(b - a, p - a)) / std::max(1e-300, length(b - a)));
            ASSERT_TRUE(inside || least < 1e-9) << k;
        }
    }
}

const std::vector<Triangle> quad{{{0, 0, 1}, {2, 0, 1}, {2, 1, 1}, 5}, {{0, 0, 1}, {2, 1, 1}, {0, 1, 1}, 5}};
// An L of six triangles: the unit squares at (0, 0), (1, 0) and (0, 1).
const std::vector<Triangle> ell{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, 2}, {{0, 0, 0}, {1, 1, 0}, {0, 1, 0}, 2},
                                {{1, 0, 0}, {2, 0, 0}, {2, 1, 0}, 2}, {{1, 0, 0}, {2, 1, 0}, {1, 1, 0}, 2},
                                {{0, 1, 0}, {1, 1, 0}, {1, 2, 0}, 2}, {{0, 1, 0}, {1, 2, 0}, {0, 2, 0}, 2}};

TEST(PatchCells, PartitionAQuad) {
    expect_partition(quad, {{0.5, 0.25, 1}, {1.5, 0.25, 1}, {1.5, 0.75, 1}, {0.5, 0.75, 1}});
    expect_partition(quad, {{0.1, 0.9, 1}, {0.15, 0.2, 1}, {1.2, 0.6, 1}, {1.9, 0.85, 1}});
    expect_partition(quad, {{0.3, 0.5, 1}});
    // Points off the patch have their share all the same, or none.
    expect_partition(quad, {{-1, 0.5, 1}, {1, 0.5, 1}, {20, 0.5, 1}});
}

TEST(PatchCells, PartitionAnL) {
    expect_partition(ell, {{0.4, 0.4, 0}, {1.6, 0.5, 0}, {0.5, 1.7, 0}, {0.9, 0.8, 0}});
    expect_partition(ell, {{0.1, 0.1, 0}, {1.9, 0.1, 0}, {0.1, 1.9, 0}, {0.2, 0.3, 0}});
}

TEST(PatchCells, PartitionAPatchThatIsTilted) {
    std::vector<Triangle> patch = ell;
    const Vec3 u = normalized({1, 2, 3}), v = normalized(cross(u, {0, 0, 1})), offset{1e5, -2e5, 3};
    const auto moved = [&](const Vec3& p) { return offset + p.x * u + p.y * v; };
    for (Triangle& t : patch) t = {moved(t.a), moved(t.b), moved(t.c), t.surfel};
    const std::vector<Vec3> points{moved({0.4, 0.4, 0}), moved({1.6, 0.5, 0}), moved({0.5, 1.7, 0})};
    const auto cells = patch_cells(patch.data(), patch.data() + patch.size(), points.data(), points.size());
    double sum = 0.0;
    for (const auto& cell : cells) sum += area_of_all(cell);
    EXPECT_NEAR(sum, 3.0, 1e-9);  // coordinates hold 3e-11 there
}

TEST(PatchCells, EqualSharesOfASquareByFour) {
    const auto cells =
        patch_cells(quad.data(), quad.data() + 2,
                    std::vector<Vec3>{{0.5, 0.25, 1}, {1.5, 0.25, 1}, {1.5, 0.75, 1}, {0.5, 0.75, 1}}.data(), 4);
    for (const auto& cell : cells) EXPECT_NEAR(area_of_all(cell), 0.5, 1e-14);
}

TEST(PatchCells, NothingOfNothing) {
    const Vec3 points[2] = {{0, 0, 0}, {1, 0, 0}};
    const auto cells = patch_cells(quad.data(), quad.data(), points, 2);
    ASSERT_EQ(cells.size(), 2u);
    EXPECT_TRUE(cells[0].empty());
    EXPECT_TRUE(cells[1].empty());
}

}  // namespace
}  // namespace surflux
