#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "surflux/core/sampling.h"
#include "surflux/solution/interpolation.h"

namespace surflux {
namespace {

using Weights = std::vector<Interpolation::Weight>;

const Vec3 up{0, 0, 1}, down{0, 0, -1};

struct Sites {
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> objects;

    void add(const Vec3& position, const Vec3& normal, std::uint32_t object = 0) {
        positions.push_back(position);
        normals.push_back(normal);
        objects.push_back(object);
    }
    // n x n over the unit square at a height, a little off a grid.
    void add_square(int n, double z, const Vec3& normal, std::uint32_t object = 0, double jitter = 0.6) {
        Random random(object, static_cast<std::uint64_t>(n));
        for (int a = 0; a < n; ++a)
            for (int b = 0; b < n; ++b)
                add({(a + 0.5 + jitter * (random.uniform() - 0.5)) / n,
                     (b + 0.5 + jitter * (random.uniform() - 0.5)) / n, z},
                    normal, object);
    }
};

Weights weights_at(const Interpolation& of, const Vec3& point, const Vec3& normal, std::uint32_t object) {
    Weights out;
    of.at(point, normal, object, out);
    return out;
}

void expect_shares(const Weights& weights) {
    double sum = 0.0;
    std::set<std::uint32_t> sites;
    for (const auto& w : weights) {
        EXPECT_GE(w.weight, 0.0);
        sum += w.weight;
        sites.insert(w.site);
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
    EXPECT_EQ(sites.size(), weights.size());
}

TEST(Interpolation, WeightsArePositiveAndSumToOne) {
    Sites s;
    s.add_square(20, 0.0, up);
    const Interpolation field(s.positions, s.normals, s.objects);
    Random random(3, 0);
    for (int k = 0; k < 500; ++k) {
        // On the surface, beyond its border, off it, and with normals that lean.
        const Vec3 point{2 * random.uniform() - 0.5, 2 * random.uniform() - 0.5, 0.1 * (random.uniform() - 0.5)};
        expect_shares(weights_at(field, point, normalized({random.uniform() - 0.5, 0.3, 1}), 0));
    }
}

TEST(Interpolation, IsExactAtSites) {
    Sites s;
    s.add_square(15, 0.0, up);
    const Interpolation field(s.positions, s.normals, s.objects);
    for (std::uint32_t i = 0; i < s.positions.size(); ++i) {
        const Weights weights = weights_at(field, s.positions[i], up, 0);
        ASSERT_EQ(weights.size(), 1u);
        EXPECT_EQ(weights[0].site, i);
        EXPECT_EQ(weights[0].weight, 1.0);
        // And nearly so beside them: no jump between the two.
        for (const auto& w : weights_at(field, s.positions[i] + Vec3{1e-5, 0, 0}, up, 0))
            if (w.site == i) {
                EXPECT_GT(w.weight, 1.0 - 1e-4);
            }
    }
}

TEST(Interpolation, DoesNotJumpFromPlaceToPlace) {
    // The farthest of the nearest has no weight: as it drops out nothing happens. Shares of any fixed number of
    // neighbours, or inverse distances cut short, would jump by per cents.
    Sites s;
    s.add_square(12, 0.0, up);
    const Interpolation field(s.positions, s.normals, s.objects);
    std::vector<double> before(s.positions.size(), 0.0), now;
    const int steps = 20000;
    double largest = 0.0;
    for (int k = 0; k <= steps; ++k) {
        now.assign(before.size(), 0.0);
        for (const auto& w : weights_at(field, {0.2 + 0.6 * k / steps, 0.3 + 0.4 * k / steps, 0.0}, up, 0))
            now[w.site] = w.weight;
        for (std::size_t i = 0; k > 0 && i < now.size(); ++i) largest = std::max(largest, std::abs(now[i] - before[i]));
        before = now;
    }
    EXPECT_LT(largest, 0.01);  // a step is 4e-4 of a spacing; slopes at a site reach 20 per spacing
}

TEST(Interpolation, NothingComesFromOtherObjects) {
    // Two sheets in one plane that lie through each other, and a third that is far.
    Sites s;
    s.add_square(10, 0.0, up, 0);
    s.add_square(11, 0.0, up, 4);  // numbers between may be missing
    s.add_square(3, 50.0, up, 2);
    const Interpolation field(s.positions, s.normals, s.objects);
    Random random(5, 0);
    for (int k = 0; k < 200; ++k) {
        const Vec3 point{random.uniform(), random.uniform(), 0.0};
        for (std::uint32_t object : {0u, 2u, 4u}) {
            const Weights weights = weights_at(field, point, up, object);
            expect_shares(weights);
            for (const auto& w : weights) EXPECT_EQ(s.objects[w.site], object);
        }
        // Without an object all are of one, that whose surface is nearest.
        const Weights weights = weights_at(field, point, up, Interpolation::any_object);
        expect_shares(weights);
        std::size_t nearest = 0;
        for (std::size_t i = 1; i < s.positions.size(); ++i)
            if (length_squared(s.positions[i] - point) < length_squared(s.positions[nearest] - point)) nearest = i;
        for (const auto& w : weights) EXPECT_EQ(s.objects[w.site], s.objects[nearest]);
    }
}

TEST(Interpolation, ThinWallsKeepTheirSidesApart) {
    // Both faces of a wall, 1e-3 and 0 apart: what lights one says nothing of the other.
    for (double thickness : {1e-3, 0.0}) {
        Sites s;
        s.add_square(12, thickness, up);
        s.add_square(12, 0.0, down);
        const Interpolation field(s.positions, s.normals, s.objects);
        Random random(6, 0);
        for (int k = 0; k < 200; ++k) {
            const Vec3 point{random.uniform(), random.uniform(), 0.0};
            for (const auto& w : weights_at(field, point, up, 0)) EXPECT_EQ(s.normals[w.site].z, 1.0);
            for (const auto& w : weights_at(field, point, down, Interpolation::any_object))
                EXPECT_EQ(s.normals[w.site].z, -1.0);
        }
    }
}

TEST(Interpolation, AFloorKnowsNothingOfTheWallsBesideIt) {
    Sites s;
    s.add_square(10, 0.0, up);
    for (int a = 0; a < 10; ++a)
        for (int b = 0; b < 10; ++b) s.add({0.0, (a + 0.5) / 10, (b + 0.5) / 10}, {1, 0, 0});
    const Interpolation field(s.positions, s.normals, s.objects);
    for (double y : {0.11, 0.52, 0.93}) {
        for (const auto& w : weights_at(field, {0.001, y, 0.0}, up, 0)) EXPECT_EQ(s.normals[w.site].z, 1.0);
        for (const auto& w : weights_at(field, {0.0, y, 0.001}, {1, 0, 0}, 0)) EXPECT_EQ(s.normals[w.site].x, 1.0);
    }
}

TEST(Interpolation, StepsOfAStairAreTakenFromTheirOwnTreads) {
    // Treads that face alike, a third of a spacing apart in height: what is off the surface counts as farther.
    Sites s;
    s.add_square(10, 0.0, up, 0, 0.0);
    s.add_square(10, 0.05, up, 0, 0.0);
    const Interpolation field(s.positions, s.normals, s.objects);
    double own = 0.0;
    for (const auto& w : weights_at(field, {0.5, 0.5, 0.0}, up, 0))
        own += s.positions[w.site].z == 0.0 ? w.weight : 0.0;
    EXPECT_GT(own, 0.75);
}

TEST(Interpolation, WhereNothingFacesItsWayTheNearestSpeaksAlone) {
    Sites s;
    s.add_square(6, 0.0, up, 0, 0.0);
    const Interpolation field(s.positions, s.normals, s.objects);
    for (std::uint32_t object : {0u, Interpolation::any_object}) {
        const Weights weights = weights_at(field, {0.26, 0.26, 0.0}, down, object);
        ASSERT_EQ(weights.size(), 1u);
        EXPECT_EQ(weights[0].weight, 1.0);
        EXPECT_NEAR(s.positions[weights[0].site].x, 0.25, 1e-12);
        EXPECT_NEAR(s.positions[weights[0].site].y, 0.25, 1e-12);
    }
}

TEST(Interpolation, OneTwoAndThreeSitesAreEnough) {
    for (std::size_t count : {1u, 2u, 3u}) {
        Sites s;
        for (std::size_t k = 0; k < count; ++k)
            s.add({static_cast<double>(k), 0.1 * static_cast<double>(k * k), 0}, up);
        const Interpolation field(s.positions, s.normals, s.objects);
        for (double x : {-3.0, 0.3, 0.5, 1.7, 9.0}) expect_shares(weights_at(field, {x, 0.2, 0}, up, 0));
    }
    // Several at one place.
    Sites s;
    for (int k = 0; k < 12; ++k) s.add({0, 0, 0}, up);
    const Interpolation field(s.positions, s.normals, s.objects);
    expect_shares(weights_at(field, {0, 0, 0}, up, 0));
    expect_shares(weights_at(field, {0.5, 0, 0}, up, 0));
}

TEST(Interpolation, TheNearestComeNearestFirst) {
    Sites s;
    s.add_square(20, 0.0, up);
    const Interpolation field(s.positions, s.normals, s.objects);
    Weights near;
    field.nearest({0.4, 0.6, 0.0}, up, 0, 9, near);
    ASSERT_EQ(near.size(), 9u);
    std::vector<double> distances;
    for (const Vec3& p : s.positions) distances.push_back(length(p - Vec3{0.4, 0.6, 0.0}));
    std::sort(distances.begin(), distances.end());
    for (std::size_t k = 0; k < near.size(); ++k) EXPECT_NEAR(near[k].weight, distances[k], 1e-12);
}

TEST(Interpolation, FindsFewThatFaceItsWayAmongManyThatDoNot) {
    // A sheet above a crowd that faces down: twenty nearest are all of the crowd.
    Sites s;
    s.add_square(4, 0.02, up, 0, 0.0);
    s.add_square(24, 0.0, down, 0, 0.0);
    const Interpolation field(s.positions, s.normals, s.objects);
    const Weights weights = weights_at(field, {0.5, 0.5, 0.02}, up, 0);
    EXPECT_GE(weights.size(), 4u);
    for (const auto& w : weights) EXPECT_EQ(s.normals[w.site].z, 1.0);
}

}  // namespace
}  // namespace surflux
