#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "nested_points.h"
#include "refusal.h"
#include "surflux/core/parallel.h"
#include "surflux/meshless/shepard_level.h"

namespace surflux {
namespace {

using shapes::SurfacePoints;
using Weights = std::vector<BasisWeight>;

const Vec3 up{0, 0, 1}, down{0, 0, -1};

ShepardLevel level_of(const SurfacePoints& of, const SupportOptions& options = {}) {
    return {of.positions, of.normals, of.objects, options};
}

Weights weights_at(const ShepardLevel& level, const Vec3& point, const Vec3& normal, std::uint32_t object = 0) {
    Weights out;
    level.at(point, normal, object, out);
    return out;
}

Weights weights_or_nearest(const ShepardLevel& level, const Vec3& point, const Vec3& normal, std::uint32_t object = 0) {
    Weights out;
    level.at_or_nearest(point, normal, object, out);
    return out;
}

double sum_of(const Weights& weights) {
    double sum = 0.0;
    for (const BasisWeight& w : weights) sum += w.weight;
    return sum;
}

// L07 eqs. 12 and 13, of all functions.
std::vector<double> kernels(const SurfacePoints& of, const ShepardLevel& level, const Vec3& point, const Vec3& normal,
                            std::uint32_t object) {
    std::vector<double> out(of.size(), 0.0);
    for (std::uint32_t j = 0; j < of.size(); ++j) {
        const double t = length(point - of.positions[j]) / level.radius(j);
        if (of.objects[j] == object && t < 1.0)
            out[j] = (2 * t * t * t - 3 * t * t + 1) * std::pow(std::max(0.0, dot(normal, of.normals[j])), 4.0);
    }
    return out;
}

// By L07 sec. 4.2, each distance looked at.
double radius_of(const SurfacePoints& of, std::uint32_t j, std::size_t k) {
    std::vector<double> distances;
    for (std::uint32_t i = 0; i < of.size(); ++i)
        if (i != j && of.objects[i] == of.objects[j] && dot(of.normals[i], of.normals[j]) > 0.0)
            distances.push_back(length(of.positions[i] - of.positions[j]));
    std::sort(distances.begin(), distances.end());
    return distances[k - 1];
}

SurfacePoints moved(SurfacePoints of, const Vec3& by) {
    for (Vec3& p : of.positions) p += by;
    return of;
}

// A sphere, a box that it stands in, and a plate with two faces a hair apart, of three objects.
SurfacePoints three_objects() {
    SurfacePoints out = shapes::drawn(shapes::draw_on_sphere, 700, 1, 4);
    out.append(shapes::drawn(shapes::draw_on_box, 900, 2, 0));
    for (const Vec3& normal : {up, down}) {
        SurfacePoints face = shapes::drawn(shapes::draw_on_square, 150, 3, 7);
        for (std::size_t i = 0; i < face.size(); ++i)
            out.add(face.positions[i] + 1e-3 * normal, normal, face.objects[i]);
    }
    return out;
}

TEST(ShepardLevel, RadiiReachTheTenthNeighbourThatFacesACompatibleWay) {
    const SurfacePoints of = three_objects();
    for (int k : {10, 3, 100}) {
        SupportOptions options;
        options.neighbors = k;
        const ShepardLevel level = level_of(of, options);
        for (std::uint32_t j = 0; j < of.size(); j += 7)
            ASSERT_NEAR(level.radius(j), radius_of(of, j, static_cast<std::size_t>(k)), 1e-12) << j << " " << k;
        options.largest_radius = 0.1;
        const ShepardLevel bounded = level_of(of, options);
        for (std::uint32_t j = 0; j < of.size(); j += 7)
            EXPECT_NEAR(bounded.radius(j), std::min(0.1, level.radius(j)), 1e-12);
    }
}

TEST(ShepardLevel, ThatIsAboutTenFunctionsOnEachSideOfAThinPlate) {
    SurfacePoints of;
    for (const Vec3& normal : {up, down}) {
        const SurfacePoints face = shapes::nested_points(shapes::draw_on_square, 0.03, 1, 5)[0];
        for (const Vec3& p : face.positions) of.add(p + 1e-4 * normal, normal);
    }
    const ShepardLevel level = level_of(of);
    Random random(6);
    double count = 0.0;
    std::size_t least = 100;
    for (int k = 0; k < 1000; ++k) {
        const Vec3 point{0.2 + 0.6 * random.uniform(), 0.2 + 0.6 * random.uniform(), 0.0};
        const Weights weights = weights_at(level, point, k % 2 ? up : down);
        count += static_cast<double>(weights.size()) / 1000.0;
        least = std::min(least, weights.size());
        for (const BasisWeight& w : weights) EXPECT_EQ(of.normals[w.function].z, k % 2 ? 1.0 : -1.0);
    }
    EXPECT_NEAR(count, 10.0, 1.0);
    EXPECT_GE(least, 6u);
}

TEST(ShepardLevel, AgreesWithTheEquationsSummedOverAllFunctions) {
    // Also 5e6 m from the origin, where a float has steps of half a metre.
    for (const Vec3& offset : {Vec3{}, Vec3{5e6, -3e6, 100.0}}) {
        const SurfacePoints of = moved(three_objects(), offset);
        const ShepardLevel level = level_of(of);
        Random random(8);
        std::map<std::size_t, int> seen;
        for (int k = 0; k < 3000; ++k) {
            const std::uint32_t object = std::array<std::uint32_t, 3>{4, 0, 7}[random.below(3)];
            Vec3 point, normal, lean{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
            if (object == 4) shapes::draw_on_sphere(random, point, normal);
            if (object == 0) shapes::draw_on_box(random, point, normal);
            if (object == 7) shapes::draw_on_square(random, point, normal);
            // Off the surface, and beyond its border, too.
            point += offset + random.uniform() * random.uniform() * lean;
            normal = normalized(normal + 0.8 * lean);
            const std::vector<double> expected = kernels(of, level, point, normal, object);
            double sum = 0.0;
            for (double w : expected) sum += w;
            const Weights weights = weights_at(level, point, normal, object);
            ++seen[weights.size()];
            std::vector<double> got(of.size(), 0.0);
            for (const BasisWeight& w : weights) {
                EXPECT_GT(w.weight, 0.0);
                EXPECT_EQ(got[w.function], 0.0) << "twice";
                got[w.function] = w.weight;
            }
            if (!weights.empty()) {
                EXPECT_NEAR(sum_of(weights), 1.0, 1e-12);
            }
            for (std::size_t j = 0; sum > 1e-6 && j < of.size(); ++j)
                EXPECT_NEAR(got[j], expected[j] / sum, 4e-6 / std::min(1.0, 10 * sum));
        }
        EXPECT_GE(seen.size(), 12u);
        EXPECT_GT(seen[0], 10);
    }
}

TEST(ShepardLevel, FunctionsSumToOneWhereverAnyIsNotZero) {
    for (const shapes::DrawPoint& draw :
         {shapes::DrawPoint(shapes::draw_on_square), shapes::DrawPoint(shapes::draw_on_sphere),
          shapes::DrawPoint(shapes::draw_on_box)}) {
        const SurfacePoints of = shapes::nested_points(draw, 0.06, 1, 2)[0];
        const ShepardLevel level = level_of(of);
        const SurfacePoints points = shapes::drawn(draw, 20000, 9);
        double functions = 0.0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Weights weights = weights_at(level, points.positions[i], points.normals[i]);
            ASSERT_FALSE(weights.empty());
            ASSERT_NEAR(sum_of(weights), 1.0, 1e-12);
            functions += static_cast<double>(weights.size()) / static_cast<double>(points.size());
        }
        EXPECT_NEAR(functions, 10.0, 1.0);
    }
}

TEST(ShepardLevel, DoesNotJumpAlongAWalk) {
    // A step is 1e-4 long, supports are 0.1 and more wide and slopes of K at most 1.5 of that.
    const ShepardLevel plane = level_of(shapes::nested_points(shapes::draw_on_square, 0.06, 1, 2)[0]);
    const ShepardLevel sphere = level_of(shapes::nested_points(shapes::draw_on_sphere, 0.06, 1, 2)[0]);
    for (const ShepardLevel* level : {&plane, &sphere}) {
        std::vector<double> before(level->size(), 0.0), now;
        double largest = 0.0;
        for (int k = 0; k <= 10000; ++k) {
            const double s = k * 1e-4;
            const double z = 0.95 - 0.3 * s, r = std::sqrt(1.0 - z * z);
            const Vec3 out{r * std::cos(3 * s), r * std::sin(3 * s), z};
            now.assign(level->size(), 0.0);
            for (const BasisWeight& w :
                 level == &plane ? weights_at(*level, {s, 0.2 + 0.6 * s * s, 0.0}, up) : weights_at(*level, out, out))
                now[w.function] = w.weight;
            for (std::size_t j = 0; k > 0 && j < now.size(); ++j)
                largest = std::max(largest, std::abs(now[j] - before[j]));
            before = now;
        }
        EXPECT_LT(largest, 0.01);
        EXPECT_GT(largest, 1e-4);
    }
}

TEST(ShepardLevel, CrossesTheBorderOfASupportWithoutAStep) {
    // Where one support ends the others go on, and the weight is down to rounding.
    const SurfacePoints of = shapes::nested_points(shapes::draw_on_square, 0.06, 1, 2)[0];
    const ShepardLevel level = level_of(of);
    int crossed = 0;
    for (std::uint32_t j = 0; j < of.size(); ++j) {
        const Vec3 way{std::cos(0.1 * j), std::sin(0.1 * j), 0.0};
        const Vec3 inside = of.positions[j] + (1.0 - 1e-4) * level.radius(j) * way;
        if (std::max(std::abs(inside.x - 0.5), std::abs(inside.y - 0.5)) > 0.4) continue;
        for (const BasisWeight& w : weights_at(level, inside, up))
            if (w.function == j) {
                EXPECT_LT(w.weight, 1e-6);
                ++crossed;
            }
        for (const BasisWeight& w : weights_at(level, of.positions[j] + (1.0 + 1e-6) * level.radius(j) * way, up))
            EXPECT_NE(w.function, j);
    }
    EXPECT_GT(crossed, 100);
}

TEST(ShepardLevel, NothingCoversWhatIsFarOrFacesAway) {
    const SurfacePoints of = shapes::nested_points(shapes::draw_on_square, 0.1, 1, 2)[0];
    const ShepardLevel level = level_of(of);
    EXPECT_TRUE(weights_at(level, {0.5, 0.5, 2.0}, up).empty());
    EXPECT_TRUE(weights_at(level, {1e9, 0.5, 0.0}, up).empty());
    EXPECT_TRUE(weights_at(level, {0.5, 0.5, 0.0}, down).empty());
    EXPECT_TRUE(weights_at(level, {0.5, 0.5, 0.0}, {1, 0, 0}).empty());
    EXPECT_TRUE(weights_at(level, {0.5, 0.5, 0.0}, up, 3).empty());
    EXPECT_FALSE(weights_at(level, {0.5, 0.5, 0.0}, up).empty());
    EXPECT_TRUE(level.has(0));
    EXPECT_FALSE(level.has(3));
    EXPECT_TRUE(weights_or_nearest(level, {0.5, 0.5, 0.0}, up, 3).empty());
    const ShepardLevel none = level_of({});
    EXPECT_EQ(none.size(), 0u);
    EXPECT_TRUE(weights_or_nearest(none, {0.5, 0.5, 0.0}, up).empty());
}

TEST(ShepardLevel, WhereNothingCoversItTheNearestThatFacesItsWaySpeaksAlone) {
    const SurfacePoints of = three_objects();
    const ShepardLevel level = level_of(of);
    Random random(4);
    int fell_back = 0, none_faced = 0;
    for (int k = 0; k < 3000; ++k) {
        const Vec3 point{4 * random.uniform() - 2, 4 * random.uniform() - 2, 4 * random.uniform() - 2};
        Vec3 normal, unused;
        shapes::draw_on_sphere(random, unused, normal);
        if (k % 5 == 0) normal = {1, 0, 0};
        const std::uint32_t object = std::array<std::uint32_t, 3>{4, 0, 7}[random.below(3)];
        const Weights covered = weights_at(level, point, normal, object);
        const Weights weights = weights_or_nearest(level, point, normal, object);
        if (!covered.empty()) {
            ASSERT_EQ(covered.size(), weights.size());
            continue;
        }
        ASSERT_EQ(weights.size(), 1u);
        EXPECT_EQ(weights[0].weight, 1.0);
        double least[2] = {1e300, 1e300};
        for (std::uint32_t j = 0; j < of.size(); ++j) {
            if (of.objects[j] != object) continue;
            const double distance = length(of.positions[j] - point);
            least[1] = std::min(least[1], distance);
            if (dot(of.normals[j], normal) > 0.0) least[0] = std::min(least[0], distance);
        }
        none_faced += least[0] == 1e300;
        ++fell_back;
        EXPECT_EQ(of.objects[weights[0].function], object);
        EXPECT_NEAR(length(of.positions[weights[0].function] - point), least[0] == 1e300 ? least[1] : least[0], 1e-6);
    }
    EXPECT_GT(fell_back, 1000);
    EXPECT_GT(none_faced, 50);
}

TEST(ShepardLevel, OneAndTwoPointsAreALevel) {
    SurfacePoints of;
    of.add({1, 2, 3}, up);
    const ShepardLevel one = level_of(of);
    EXPECT_EQ(one.radius(0), 0.0);
    EXPECT_TRUE(weights_at(one, {1, 2, 3}, up).empty());
    for (const Vec3& normal : {up, down, Vec3{1, 0, 0}}) {
        const Weights weights = weights_or_nearest(one, {9, 2, 3}, normal);
        ASSERT_EQ(weights.size(), 1u);
        EXPECT_EQ(weights[0].weight, 1.0);
    }
    SupportOptions bounded;
    bounded.largest_radius = 0.5;
    EXPECT_EQ(level_of(of, bounded).radius(0), 0.5);
    EXPECT_EQ(weights_at(level_of(of, bounded), {1.4, 2, 3}, up).size(), 1u);
    EXPECT_TRUE(weights_at(level_of(of, bounded), {1.6, 2, 3}, up).empty());
    // Two that face alike share what is between them. Two that do not have no support, and the one that faces speaks.
    of.add({2, 2, 3}, up);
    const ShepardLevel two = level_of(of);
    EXPECT_NEAR(two.radius(0), std::sqrt(10.0), 1e-12);
    const Weights weights = weights_at(two, {1.5, 2, 3}, up);
    ASSERT_EQ(weights.size(), 2u);
    EXPECT_NEAR(weights[0].weight, 0.5, 1e-7);
    of.normals[1] = down;
    const ShepardLevel apart = level_of(of);
    EXPECT_EQ(apart.radius(1), 0.0);
    EXPECT_EQ(weights_or_nearest(apart, {1.9, 2, 3}, up)[0].function, 0u);
    EXPECT_EQ(weights_or_nearest(apart, {1.1, 2, 3}, down)[0].function, 1u);
}

TEST(ShepardLevel, PilesOfCoincidentPointsBreakNothing) {
    SurfacePoints of;
    for (int k = 0; k < 500; ++k) of.add({0, 0, 0}, up);
    const ShepardLevel pile = level_of(of);
    EXPECT_EQ(pile.radius(3), 0.0);
    EXPECT_EQ(weights_or_nearest(pile, {0, 0, 0}, up).size(), 1u);
    EXPECT_EQ(weights_or_nearest(pile, {0, 0, 0}, up)[0].function, 0u);
    // Among others each has the support of a single point there, and they share it.
    const SurfacePoints around = shapes::drawn(shapes::draw_on_square, 300, 1);
    for (const Vec3& p : around.positions) of.add(p - Vec3{0.5, 0.5, 0.0}, up);
    const ShepardLevel level = level_of(of);
    std::vector<double> distances;
    for (const Vec3& p : around.positions) distances.push_back(length(p - Vec3{0.5, 0.5, 0.0}));
    std::sort(distances.begin(), distances.end());
    EXPECT_NEAR(level.radius(0), distances[9], 1e-12);
    const Weights weights = weights_at(level, {0.01, 0.01, 0}, up);
    EXPECT_GT(weights.size(), 500u);
    EXPECT_NEAR(sum_of(weights), 1.0, 1e-12);
    // Points on a line, and one far out.
    SurfacePoints line;
    for (int k = 0; k < 50; ++k) line.add({0.1 * k, 0, 0}, up);
    line.add({1e7, 0, 0}, up);
    EXPECT_NEAR(level_of(line).radius(20), 0.5, 1e-12);
    EXPECT_NEAR(sum_of(weights_at(level_of(line), {2.03, 0, 0}, up)), 1.0, 1e-12);
}

TEST(ShepardLevel, IsTheSameForAnyNumberOfThreads) {
    const SurfacePoints of = three_objects();
    const SurfacePoints points = shapes::drawn(shapes::draw_on_box, 5000, 3);
    std::vector<Weights> first;
    for (int threads : {1, 3}) {
        const ThreadLimit limit(threads);
        const ShepardLevel level = level_of(of);
        std::vector<Weights> all(points.size());
        parallel_for(points.size(), 64,
                     [&](std::size_t i) { level.at(points.positions[i], points.normals[i], 0, all[i]); });
        if (first.empty()) first = all;
        for (std::size_t i = 0; i < all.size(); ++i) {
            ASSERT_EQ(all[i].size(), first[i].size());
            for (std::size_t k = 0; k < all[i].size(); ++k) {
                EXPECT_EQ(all[i][k].function, first[i][k].function);
                EXPECT_EQ(all[i][k].weight, first[i][k].weight);
            }
        }
    }
}

TEST(ShepardLevel, SaysWhatItCannotTake) {
    const std::vector<Vec3> two{{0, 0, 0}, {1, 0, 0}}, one{up}, faces{up, up};
    const std::vector<std::uint32_t> objects{0, 0};
    const auto made = [&](const auto& x, const auto& n, const auto& o, SupportOptions options = {}) {
        return refusal([&] { ShepardLevel(x, n, o, options); });
    };
    EXPECT_EQ(made(two, one, objects), "normals: there are 1, wanted one for each of 2 positions");
    EXPECT_EQ(made(two, faces, std::vector<std::uint32_t>{0}),
              "objects: there are 1, wanted one for each of 2 positions");
    EXPECT_EQ(made(std::vector<Vec3>{{0, 0, 0}, {NAN, 0, 0}}, faces, objects), "positions: number 1 is not finite");
    EXPECT_EQ(made(two, std::vector<Vec3>{up, {0, 0, 2}}, objects), "normals: number 1 is not of unit length");
    EXPECT_EQ(made(two, std::vector<Vec3>{{NAN, 0, 0}, up}, objects), "normals: number 0 is not of unit length");
    SupportOptions options;
    options.neighbors = 0;
    EXPECT_EQ(made(two, faces, objects, options), "neighbors: got 0, wanted at least 1");
    options.neighbors = 10;
    options.largest_radius = 0.0;
    EXPECT_EQ(made(two, faces, objects, options), "largest_radius: got 0, wanted more than 0");
}

}  // namespace
}  // namespace surflux
