#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "basis_functions.h"
#include "nested_points.h"
#include "refusal.h"
#include "shapes.h"
#include "surflux/core/parallel.h"
#include "surflux/meshless/multilevel_basis.h"

namespace surflux {
namespace {

using shapes::SurfacePoints;

const Vec3 up{0, 0, 1}, down{0, 0, -1};

MultilevelBasis basis_of(const std::vector<SurfacePoints>& levels) {
    MultilevelBasis basis;
    for (const SurfacePoints& level : levels) basis.add_level(level.positions, level.normals, level.objects);
    return basis;
}

double smooth(const Vec3& p) { return 2.0 + std::sin(3.0 * p.x + 1.0) * std::cos(2.0 * p.y) + 0.5 * p.z * p.x; }

std::vector<double> values_of(const MultilevelBasis& basis) {
    std::vector<double> out(basis.size());
    for (std::uint32_t j = 0; j < basis.size(); ++j) out[j] = smooth(basis.position(j));
    return out;
}

template <class Value>
std::vector<Value> evaluate_at(const MultilevelBasis& basis, const SurfacePoints& points,
                               const std::vector<Value>& coefficients,
                               std::size_t levels = MultilevelBasis::all_levels) {
    std::vector<Value> out;
    for (std::size_t i = 0; i < points.size(); ++i)
        out.push_back(
            shapes::evaluate(basis, points.positions[i], points.normals[i], points.objects[i], coefficients, levels));
    return out;
}

// L07 eqs. 9 and 12, summed over all functions of the first levels.
double evaluated(const MultilevelBasis& basis, const Vec3& point, const Vec3& normal,
                 const std::vector<double>& coefficients, std::size_t levels) {
    double value = 0.0;
    for (std::size_t level = 0; level < levels; ++level) {
        double sum = 0.0, weighted = 0.0;
        for (std::uint32_t j = basis.first(level); j < basis.first(level + 1); ++j) {
            const double t = length(point - basis.position(j)) / basis.radius(j);
            if (!(t < 1.0)) continue;
            const double w =
                (2 * t * t * t - 3 * t * t + 1) * std::pow(std::max(0.0, dot(normal, basis.normal(j))), 4.0);
            sum += w;
            weighted += w * coefficients[j];
        }
        if (sum > 0.0) value += weighted / sum;
    }
    return value;
}

TEST(MultilevelBasis, NumbersFunctionsThroughItsLevels) {
    const auto points = shapes::nested_points(shapes::draw_on_sphere, 0.5, 3, 1);
    const MultilevelBasis basis = basis_of(points);
    ASSERT_EQ(basis.levels(), 3u);
    EXPECT_EQ(basis.size(), points[0].size() + points[1].size() + points[2].size());
    EXPECT_EQ(basis.first(3), basis.size());
    for (std::uint32_t level = 0; level < 3; ++level) {
        const ShepardLevel alone(points[level].positions, points[level].normals, points[level].objects);
        ASSERT_EQ(basis.first(level + 1) - basis.first(level), points[level].size());
        for (std::uint32_t k = 0; k < points[level].size(); ++k) {
            const std::uint32_t j = basis.first(level) + k;
            EXPECT_EQ(basis.level_of(j), level);
            EXPECT_EQ(basis.radius(j), alone.radius(k));
            EXPECT_EQ(basis.position(j), points[level].positions[k]);
            EXPECT_EQ(basis.normal(j), points[level].normals[k]);
            EXPECT_EQ(basis.object(j), 0u);
        }
    }
}

TEST(MultilevelBasis, ProjectsAndEvaluatesAsTheEquationsSay) {
    const MultilevelBasis basis = basis_of(shapes::nested_points(shapes::draw_on_sphere, 0.4, 4, 1));
    const std::vector<double> values = values_of(basis), coefficients = shapes::project(basis, values);
    for (std::uint32_t j = 0; j < basis.size(); ++j) {
        const double coarser = evaluated(basis, basis.position(j), basis.normal(j), coefficients, basis.level_of(j));
        ASSERT_NEAR(coefficients[j], values[j] - coarser, 1e-5);
    }
    const SurfacePoints points = shapes::drawn(shapes::draw_on_sphere, 300, 4);
    for (std::size_t level = 0; level < 4; ++level) {
        const auto all = evaluate_at(basis, points, coefficients, level + 1);
        for (std::size_t i = 0; i < points.size(); ++i)
            EXPECT_NEAR(all[i], evaluated(basis, points.positions[i], points.normals[i], coefficients, level + 1),
                        1e-5);
    }
}

TEST(MultilevelBasis, ConstantsAreKeptAndThreeChannelsAreThreeTimesOne) {
    const MultilevelBasis basis = basis_of(shapes::nested_points(shapes::draw_on_sphere, 0.4, 3, 1));
    const SurfacePoints points = shapes::drawn(shapes::draw_on_sphere, 200, 4);
    std::vector<Rgb> values(basis.size());
    std::vector<double> grey(basis.size());
    for (std::uint32_t j = 0; j < basis.size(); ++j) {
        grey[j] = smooth(basis.position(j));
        values[j] = {grey[j], 7.25, -grey[j]};
    }
    const std::vector<Rgb> coefficients = shapes::project(basis, values);
    const std::vector<double> one = shapes::project(basis, grey);
    const auto got = evaluate_at(basis, points, coefficients);
    const auto expected = evaluate_at(basis, points, one);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_NEAR(got[i].x, expected[i], 1e-13);
        EXPECT_NEAR(got[i].y, 7.25, 1e-13);
        EXPECT_NEAR(got[i].z, -expected[i], 1e-13);
    }
}

TEST(MultilevelBasis, KeepsNothingOfWhatIsNotActive) {
    const MultilevelBasis basis = basis_of(shapes::nested_points(shapes::draw_on_square, 0.1, 3, 1));
    std::vector<double> values = values_of(basis);
    std::vector<char> active(basis.size());
    for (std::uint32_t j = 0; j < basis.size(); ++j) active[j] = basis.level_of(j) == 0 || basis.position(j).x < 0.4;
    const std::vector<double> all = shapes::project(basis, values);
    std::vector<double> spoilt = values;
    for (std::uint32_t j = 0; j < basis.size(); ++j)
        if (!active[j]) spoilt[j] = 1e9;
    const std::vector<double> some = shapes::project(basis, spoilt, active);
    double expected, largest = 0.0;
    for (std::uint32_t j = 0; j < basis.size(); ++j) {
        const std::size_t level = basis.level_of(j);
        expected = values[j] - evaluated(basis, basis.position(j), up, some, level);
        EXPECT_NEAR(some[j], active[j] ? expected : 0.0, 1e-5);
    }
    // Far on one side it is what it is where all are active, on the other the coarsest level, and there is no jump.
    double before = 0.0;
    for (int k = 0; k <= 10000; ++k) {
        const Vec3 point{k * 1e-4, 0.5, 0.0};
        const double value = shapes::evaluate(basis, point, up, 0, some);
        if (point.x < 0.05) {
            EXPECT_NEAR(value, shapes::evaluate(basis, point, up, 0, all), 1e-12);
        }
        if (point.x > 0.85) {
            EXPECT_EQ(value, shapes::evaluate(basis, point, up, 0, all, 1));
        }
        if (k > 0) largest = std::max(largest, std::abs(value - before));
        before = value;
    }
    EXPECT_LT(largest, 0.01);
}

TEST(MultilevelBasis, FineLevelsAddNothingWhereNothingCoversThem) {
    std::vector<SurfacePoints> levels = shapes::nested_points(shapes::draw_on_square, 0.3, 3, 1);
    // An object that first appears on level 1 falls back there, and adds nothing on 2.
    levels[1].add({5, 5, 5}, up, 3);
    levels[2].add({6, 5, 5}, up, 3);
    const MultilevelBasis basis = basis_of(levels);
    std::vector<double> coefficients(basis.size(), 1.0);
    coefficients[basis.first(2) - 1] = 42.0;
    const Vec3 far{30, 30, 0};
    EXPECT_EQ(shapes::evaluate(basis, far, up, 0, coefficients), 1.0);
    EXPECT_EQ(shapes::evaluate(basis, far, down, 0, coefficients), 1.0);
    EXPECT_EQ(shapes::evaluate(basis, far, down, 3, coefficients, 1), 0.0);
    EXPECT_EQ(shapes::evaluate(basis, far, down, 3, coefficients), 42.0);
    EXPECT_EQ(shapes::evaluate(basis, far, up, 9, coefficients), 0.0);
    std::vector<BasisWeight> weights;
    basis.at_level(1, far, up, 0, weights);
    EXPECT_TRUE(weights.empty());
    basis.at_level(1, far, up, 3, weights);
    ASSERT_EQ(weights.size(), 1u);
    EXPECT_EQ(weights[0].function, basis.first(2) - 1);
    EXPECT_EQ(shapes::evaluate(MultilevelBasis(), far, up, 0, std::vector<double>{}), 0.0);
}

TEST(MultilevelBasis, IsTheSameForAnyNumberOfThreads) {
    const auto levels = shapes::nested_points(shapes::draw_on_sphere, 0.3, 3, 1);
    const SurfacePoints points = shapes::drawn(shapes::draw_on_sphere, 3000, 5);
    std::vector<double> first;
    for (int threads : {1, 3}) {
        const ThreadLimit limit(threads);
        const MultilevelBasis basis = basis_of(levels);
        const auto got = evaluate_at(basis, points, shapes::project(basis, values_of(basis)));
        if (first.empty()) first = got;
        EXPECT_EQ(first, got);
    }
}

TEST(MultilevelBasis, SaysWhatItCannotTake) {
    MultilevelBasis basis;
    basis.add_level({{0, 0, 0}, {1, 0, 0}}, {up, up}, {0, 0});
    EXPECT_EQ(refusal([&] { basis.add_level({{0, 0, 0}}, {}, {0}); }),
              "normals: there are 0, wanted one for each of 1 positions");
    EXPECT_EQ(basis.levels(), 1u);
}

struct Errors {
    double root_mean_square, largest;
};

Errors errors(const MultilevelBasis& basis, const shapes::DrawPoint& draw) {
    const SurfacePoints points = shapes::drawn(draw, 10000, 100);
    const auto got = evaluate_at(basis, points, shapes::project(basis, values_of(basis)));
    double sum = 0.0, largest = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double error = got[i] - smooth(points.positions[i]);
        sum += error * error;
        largest = std::max(largest, std::abs(error));
    }
    return {std::sqrt(sum / static_cast<double>(points.size())), largest};
}

// Mean orders, in the distance between points, from the second level on.
void orders(const shapes::DrawPoint& draw, std::uint64_t seed, Errors& of_levels, Errors& of_one_level) {
    const std::size_t count = 5;
    const auto points = shapes::nested_points(draw, 0.4, count, seed);
    Errors first_many{}, first_one{}, many{}, one{};
    MultilevelBasis basis;
    SurfacePoints all;
    for (std::size_t level = 0; level < count; ++level) {
        basis.add_level(points[level].positions, points[level].normals, points[level].objects);
        all.append(points[level]);
        many = errors(basis, draw);
        one = errors(basis_of({all}), draw);
        if (level == 1) first_many = many, first_one = one;
    }
    const auto order = [&](double coarse, double fine) { return std::log2(coarse / fine) / (count - 2.0); };
    of_levels = {order(first_many.root_mean_square, many.root_mean_square), order(first_many.largest, many.largest)};
    of_one_level = {order(first_one.root_mean_square, one.root_mean_square), order(first_one.largest, one.largest)};
}

// Shepard's functions reproduce constants alone: what one level leaves is of first order in the distance h between its
// points, at worst. (In the mean it is less, 1.4 to 1.6: neighbours lie about evenly around most places.) What level i
// leaves varies over distances of h_i, so that level i + 1, whose functions stand at the same ratio to that on all
// levels, leaves a fixed fraction c of it (Floater and Iske 1996, Fasshauer 2002): errors fall as 2^-i log2(1/c). That
// is faster than one level of all the points together: c is 0.19 on a closed surface. Beside a border, where all
// neighbours lie to one side, it is about 0.4. Six seeds gave for the root of the mean square and the largest error:
// sphere 2.33 to 2.45 and 1.96 to 2.16, square 2.04 to 2.15 and 1.21 to 1.56, one level 0.97 to 1.24 for the largest.
TEST(MultilevelBasis, ConvergesWithLevelFasterThanOneLevelDoes) {
    for (const std::uint64_t seed : {1u, 4u})
        for (const bool closed : {true, false}) {
            Errors of_levels, of_one_level;
            orders(closed ? shapes::draw_on_sphere : shapes::draw_on_square, seed, of_levels, of_one_level);
            EXPECT_GT(of_levels.root_mean_square, closed ? 2.1 : 1.8);
            EXPECT_GT(of_levels.largest, closed ? 1.7 : 1.0);
            EXPECT_GT(of_one_level.largest, 0.8);
            EXPECT_LT(of_one_level.largest, 1.4);
            EXPECT_GT(of_levels.root_mean_square, of_one_level.root_mean_square + 0.3);
        }
}

// A correction that no other point surrounds ends without a step: from one place to the next, a thousandth of its
// radius farther, the field changes by no more than a few thousandths of it.
TEST(MultilevelBasis, FinerLevelsFadeOutAtTheirRims) {
    MultilevelBasis basis;
    const std::vector<Vec3> normals(3, {0, 0, 1});
    basis.add_level({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, normals, {0, 0, 0}, {2, 8.0});
    basis.add_level({{1, 1, 0}, {1.2, 1, 0}, {1, 1.3, 0}}, normals, {0, 0, 0}, {10, 1.0});
    const std::vector<double> coefficients{1, 1, 1, 1, 1, 1};
    double before = shapes::evaluate(basis, {1, 1, 0}, {0, 0, 1}, 0, coefficients), steepest = 0.0;
    EXPECT_NEAR(before, 2.0, 1e-6);
    for (int k = 1; k <= 1500; ++k) {
        const double now = shapes::evaluate(basis, {1 + 0.001 * k, 1, 0}, {0, 0, 1}, 0, coefficients);
        steepest = std::max(steepest, std::abs(now - before));
        before = now;
    }
    EXPECT_NEAR(before, 1.0, 1e-6);
    EXPECT_LT(steepest, 0.005);
}

}  // namespace
}  // namespace surflux
