// Emissive patches in closed form, against the same cut finely or not at all.

#include <random>

#include <gtest/gtest.h>

#include "surflux/lights/emissive_facets.h"
#include "surflux/lights/polygon.h"

namespace surflux {
namespace {

// A grid of count x count squares, two triangles each, over [0, 1]^2 at height 0, that faces down.
std::vector<EmissiveFacets::Piece> grid(int count, const Rgb& exitance, int group = 0, const Vec3& at = {}) {
    std::vector<EmissiveFacets::Piece> out;
    const auto corner = [&](int i, int j) { return at + Vec3{1.0 * i / count, 1.0 * j / count, 0.0}; };
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) {
            const Vec3 a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1), d = corner(i, j + 1);
            out.push_back({{a, c, b}, {0, 0, -1}, exitance, 0, group});
            out.push_back({{a, d, c}, {0, 0, -1}, exitance, 0, group});
        }
    return out;
}

const Vec3 square[] = {{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}};

TEST(EmissiveFacets, AFacetIsItsBorderHoweverFinelyItIsCut) {
    for (const int count : {1, 7, 20}) {
        const EmissiveFacets facets(grid(count, {2, 3, 5}), 1);
        EXPECT_EQ(facets.edges(), 4U);
        std::mt19937 random(1);
        std::normal_distribution<double> normal;
        for (int k = 0; k < 500; ++k) {  // many of these are cut by the horizon, or look away
            const Vec3 point{normal(random), normal(random), -std::abs(normal(random)) - 1e-3};
            const Vec3 n = normalized({normal(random), normal(random), normal(random)});
            const double wanted = element_to_polygon(point, n, square, 4);
            ASSERT_NEAR(facets.form_factor(point, n), wanted, 1e-12);
            const Rgb irradiance = facets.irradiance(0U, point, n);
            ASSERT_NEAR(irradiance.x, 2 * wanted, 1e-12);
            ASSERT_NEAR(irradiance.z, 5 * wanted, 1e-12);
        }
    }
}

TEST(EmissiveFacets, NothingGoesBackwardsOrAlongItself) {
    const EmissiveFacets facets(grid(3, {1, 1, 1}), 1);
    EXPECT_EQ(facets.form_factor({0.5, 0.5, 1.0}, {0, 0, -1}), 0.0);
    EXPECT_EQ(facets.form_factor({2.0, 0.5, 0.0}, {-1, 0, 0}), 0.0);
    EXPECT_EQ(facets.form_factor({0.5, 0.5, -1.0}, {0, 0, -1}), 0.0);
}

TEST(EmissiveFacets, GroupsAndExitancesStayApart) {
    std::vector<EmissiveFacets::Piece> pieces = grid(4, {1, 1, 1}, 1);
    for (const auto& piece : grid(4, {4, 4, 4}, 1, {1, 0, 0})) pieces.push_back(piece);
    for (const auto& piece : grid(4, {9, 9, 9}, 0, {0, 1, 0})) pieces.push_back(piece);
    const EmissiveFacets facets(pieces, 3);
    EXPECT_EQ(facets.edges(), 12U);
    const Vec3 point{0.7, 0.4, -0.8}, n{0, 0, 1};
    const auto wanted = [&](const Vec3& at) {
        Vec3 corners[4];
        for (int k = 0; k < 4; ++k) corners[k] = square[k] + at;
        return element_to_polygon(point, n, corners, 4);
    };
    const auto of_group = [&](int g) {
        double sum = 0.0;
        for (std::uint32_t f = facets.first_of(g); f < facets.end_of(g); ++f) sum += facets.irradiance(f, point, n).x;
        return sum;
    };
    EXPECT_NEAR(of_group(1), wanted({}) + 4 * wanted({1, 0, 0}), 1e-12);
    EXPECT_NEAR(of_group(0), 9 * wanted({0, 1, 0}), 1e-12);
    EXPECT_EQ(of_group(2), 0.0);
    EXPECT_NEAR(facets.form_factor(point, n), wanted({}) + wanted({1, 0, 0}) + wanted({0, 1, 0}), 1e-12);
}

// Both sides of a sheet are two facets, and so is what stands twice in one place.
TEST(EmissiveFacets, PiecesInOnePlaceAreNoNeighbours) {
    for (const bool is_back : {true, false}) {
        std::vector<EmissiveFacets::Piece> pieces = grid(2, {1, 1, 1});
        for (EmissiveFacets::Piece piece : grid(2, {1, 1, 1})) {
            if (is_back) std::swap(piece.triangle.b, piece.triangle.c), piece.normal = -piece.normal;
            pieces.push_back(piece);
        }
        const EmissiveFacets facets(pieces, 1);
        const Vec3 n = normalized({0.2, 0.1, 1.0});
        const double below = element_to_polygon({0.2, 0.3, -0.5}, n, square, 4);
        EXPECT_NEAR(facets.form_factor({0.2, 0.3, -0.5}, n), is_back ? below : 2 * below, 1e-12);
        const double above = element_to_polygon({0.2, 0.3, 0.5}, -n, square, 4);
        EXPECT_NEAR(facets.form_factor({0.2, 0.3, 0.5}, -n), is_back ? above : 0.0, 1e-12);
    }
}

// The mean of what points of a facet bring is what it brings in closed form.
TEST(EmissiveFacets, SamplesAreEvenByArea) {
    const EmissiveFacets facets(grid(3, {1, 2, 4}), 1);
    const Vec3 point{0.4, 1.3, -1.0}, n = normalized({0.0, -0.3, 1.0});
    Rgb sum;
    constexpr int parts = 18 * 40, side = 40;  // of 18 triangles
    for (int i = 0; i < parts; ++i)
        for (int j = 0; j < side; ++j) {
            const auto sample = facets.sample(0, (i + 0.5) / parts, (j + 0.5) / side);
            sum += facets.irradiance(0U, sample, point, n);
        }
    const Rgb wanted = facets.irradiance(0U, point, n);
    EXPECT_NEAR(sum.x / (parts * side), wanted.x, 1e-3 * wanted.x);
    EXPECT_NEAR(sum.z / (parts * side), wanted.z, 1e-3 * wanted.z);
}

// A ring around a hole, whose border is two loops, and squares that touch at a corner, where two edges begin.
TEST(EmissiveFacets, AnyBorderWillDo) {
    for (const bool is_hole : {true, false}) {
        std::vector<EmissiveFacets::Piece> pieces;
        const std::vector<EmissiveFacets::Piece> all = grid(3, {1, 1, 1});
        for (std::size_t k = 0; k < all.size(); ++k) {
            const std::size_t i = k / 6, j = k / 2 % 3;
            if (is_hole ? !(i == 1 && j == 1) : (i + j) % 2 == 0) pieces.push_back(all[k]);
        }
        const EmissiveFacets facets(pieces, 1);
        const Vec3 point{0.4, 0.9, -0.6}, n = normalized({0.1, -0.2, 1.0});
        double wanted = 0.0;
        for (const auto& piece : pieces) {
            const Vec3 corners[] = {piece.triangle.a, piece.triangle.b, piece.triangle.c};
            wanted += element_to_polygon(point, n, corners, 3);
        }
        EXPECT_NEAR(facets.form_factor(point, n), wanted, 1e-12);
    }
}

}  // namespace
}  // namespace surflux
