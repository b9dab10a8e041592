#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

#include "surflux/core/sampling.h"
#include "surflux/solution/nodal_field.h"

namespace surflux {
namespace {

const Vec3 up{0, 0, 1};
using Values = NodalField::Values;

Rgb value_at(const NodalField& field, const Values& values, const Vec3& point, const Vec3& normal) {
    std::vector<Interpolation::Weight> weights;
    field.interpolation().at(point, normal, Interpolation::any_object, weights);
    return field.at(values, point, normal, weights);
}

std::vector<Vec3> square(std::size_t n, double jitter) {
    std::vector<Vec3> out;
    Random random(2, n);
    const double h = 1.0 / static_cast<double>(n);
    for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b)
            out.push_back({h * (static_cast<double>(a) + 0.5 + jitter * (random.uniform() - 0.5)),
                           h * (static_cast<double>(b) + 0.5 + jitter * (random.uniform() - 0.5)), 0.0});
    return out;
}

template <class F>
NodalField plane_of(const std::vector<Vec3>& at, const F& f, std::vector<Rgb>& values) {
    for (const Vec3& p : at) values.push_back(f(p));
    return NodalField(at, std::vector<Vec3>(at.size(), up), std::vector<std::uint32_t>(at.size(), 0));
}

// RMS error of the first channel at `count` places; `draw` makes one, and its normal, of random numbers.
template <class F, class Draw>
double rms_error(const NodalField& field, const Values& fit, const F& f, int count, std::uint64_t seed,
                 const Draw& draw) {
    Random random(seed, 0);
    double squared = 0.0;
    for (int k = 0; k < count; ++k) {
        const auto [p, normal] = draw(random);
        const double off = value_at(field, fit, p, normal).x - f(p).x;
        squared += off * off / count;
    }
    return std::sqrt(squared);
}

// Places of the unit square, but for a margin.
auto inside(double margin) {
    return [margin](Random& random) {
        const double x = random.uniform(), y = random.uniform(), inner = 1.0 - 2.0 * margin;
        return std::pair<Vec3, Vec3>({margin + inner * x, margin + inner * y, 0.0}, up);
    };
}

// Its interpolation refers to what it holds, and would go on to refer to a field that was moved from.
static_assert(!std::is_move_constructible_v<NodalField> && !std::is_move_assignable_v<NodalField>);
static_assert(!std::is_copy_constructible_v<NodalField> && !std::is_copy_assignable_v<NodalField>);

TEST(NodalField, IsExactAtNodesAndForConstants) {
    const std::vector<Vec3> at = square(12, 0.7);
    std::vector<Rgb> values;
    const NodalField field = plane_of(at, [](const Vec3& p) { return Rgb{2 + p.x, 3 - p.y, 1 + p.x * p.y}; }, values);
    const Values fit = field.fit(values);
    for (std::size_t k = 0; k < at.size(); ++k)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(value_at(field, fit, at[k], up)[c], values[k][c], 1e-12);
    const Values flat = field.fit(std::vector<Rgb>(at.size(), {1, 2, 3}));
    for (double x : {-0.2, 0.01, 0.345, 0.99, 1.3})
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(value_at(field, flat, {x, 0.3, 0.0}, up)[c], 1 + c, 1e-12);
}

TEST(NodalField, LinearFieldsComeOutNearlyLinear) {
    // Without slopes, Shepard's weights alone would be off by 14 % of a node's step and flat at every node.
    const std::size_t n = 16;
    std::vector<Rgb> values;
    const auto f = [](const Vec3& p) { return Rgb{5 + 3 * p.x - 2 * p.y, 5 - p.x, 5 + p.y}; };
    const NodalField field = plane_of(square(n, 0.7), f, values);
    const Values fit = field.fit(values);
    const double step = std::sqrt(13.0) / static_cast<double>(n);
    EXPECT_LT(rms_error(field, fit, f, 1000, 1, inside(0.1)), 0.03 * step);
}

template <class Error>
double order(const Error& error, std::size_t coarse, std::size_t fine) {
    return std::log(error(coarse) / error(fine)) / std::log(static_cast<double>(fine) / static_cast<double>(coarse));
}

TEST(NodalField, ConvergesOnAPlane) {
    const auto error = [](std::size_t n) {
        std::vector<Rgb> values;
        const auto f = [](const Vec3& p) { return Rgb{2 + std::sin(4 * p.x) * std::cos(3 * p.y), 1, 1}; };
        const NodalField field = plane_of(square(n, 0.7), f, values);
        return rms_error(field, field.fit(values), f, 2000, 4, inside(0.15));
    };
    EXPECT_GT(order(error, 16, 64), 1.2);
    EXPECT_LT(error(64), 1e-3);
}

std::vector<Vec3> fibonacci(std::size_t n) {
    std::vector<Vec3> out;
    for (std::size_t i = 0; i < n; ++i) {
        const double z = 1.0 - 2.0 * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
        const double phi = pi * (1.0 + std::sqrt(5.0)) * static_cast<double>(i), r = std::sqrt(1.0 - z * z);
        out.push_back({r * std::cos(phi), r * std::sin(phi), z});
    }
    return out;
}

TEST(NodalField, ConvergesOnASphere) {
    const auto error = [](std::size_t n) {
        const std::vector<Vec3> at = fibonacci(n * n);
        const auto f = [](const Vec3& p) { return Rgb{2 + p.x * p.y - 0.5 * p.z, 1, 1}; };
        std::vector<Rgb> values;
        for (const Vec3& p : at) values.push_back(f(p));
        const NodalField field(at, at, std::vector<std::uint32_t>(at.size(), 0));
        const auto on_sphere = [](Random& random) {
            const double z = 2 * random.uniform() - 1, phi = 2 * pi * random.uniform(), r = std::sqrt(1 - z * z);
            const Vec3 p{r * std::cos(phi), r * std::sin(phi), z};
            return std::make_pair(p, p);
        };
        return rms_error(field, field.fit(values), f, 2000, 4, on_sphere);
    };
    EXPECT_GT(order(error, 16, 64), 1.2);
    EXPECT_LT(error(64), 1e-3);
}

TEST(NodalField, StaysNearWhatTheNodesSay) {
    // A step: slopes beside it overshoot, but by no more than a quarter of the span, and never below nothing.
    std::vector<Rgb> values;
    const auto f = [](const Vec3& p) { return p.x < 0.5 ? Rgb{} : Rgb{1, 10, 100}; };
    const NodalField field = plane_of(square(20, 0.7), f, values);
    const Values fit = field.fit(values);
    Random random(8, 0);
    for (int k = 0; k < 3000; ++k) {
        const Rgb found = value_at(field, fit, {random.uniform(), random.uniform(), 0.0}, up);
        for (int c = 0; c < 3; ++c) {
            EXPECT_GE(found[c], 0.0);
            EXPECT_LE(found[c], 1.25 * std::pow(10.0, c) * (1 + 1e-12));
        }
    }
}

TEST(NodalField, NodesOnOneLineGiveNoSlopeAcrossIt) {
    std::vector<Vec3> at;
    std::vector<Rgb> values;
    for (int k = 0; k < 20; ++k) {
        at.push_back({0.1 * k, 0, 0});
        values.push_back({1.0 + 0.1 * k, 1, 1});
    }
    const NodalField field(at, std::vector<Vec3>(20, up), std::vector<std::uint32_t>(20, 0));
    const Values fit = field.fit(values);
    EXPECT_NEAR(value_at(field, fit, {1.03, 0.02, 0}, up).x, 2.03, 0.01);
    for (const NodalField::Slope& slope : fit.slopes) {
        EXPECT_TRUE(std::isfinite(slope.u.x) && std::isfinite(slope.v.x));
        EXPECT_LT(std::hypot(slope.u.x, slope.v.x), 1.1);
    }
    // Too few nodes for a slope.
    const NodalField three({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, std::vector<Vec3>(3, up), {0, 0, 0});
    const Values of_three = three.fit(std::vector<Rgb>{{1, 1, 1}, {2, 2, 2}, {4, 4, 4}});
    const double found = value_at(three, of_three, {0.3, 0.3, 0}, up).x;
    EXPECT_GT(found, 1.0);
    EXPECT_LT(found, 4.0);
}

TEST(NodalField, TurnsWithTheNormal) {
    // All light from one direction: value, u and v say how irradiance changes, to first order of the turn.
    const Vec3 from = normalized({1, 2, 4});
    const std::vector<Vec3> at = square(8, 0.5);
    const NodalField field(at, std::vector<Vec3>(at.size(), up), std::vector<std::uint32_t>(at.size(), 0));
    const Frame frame = frame_around(up);
    const Rgb sun{3, 2, 1};
    const std::vector<TiltedRgb> values(at.size(),
                                        {dot(from, frame.n) * sun, dot(from, frame.u) * sun, dot(from, frame.v) * sun});
    const Values fit = field.fit(values);
    for (const Vec3& lean : {up, normalized({0.3, 0, 1}), normalized({-0.2, 0.3, 1}), normalized({0.1, -0.4, 1})}) {
        const Rgb found = value_at(field, fit, {0.37, 0.52, 0.0}, lean);
        const double second_order = 1.0 - dot(lean, up);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(found[c], sun[c] * dot(from, lean), second_order * sun[c] + 1e-9);
            if (second_order > 0.0) {
                EXPECT_GT(std::abs(found[c] - sun[c] * dot(from, up)), second_order * sun[c]);  // it does turn
            }
        }
    }
}

TEST(NodalField, IsConservativeAndBoundedAtTheEdgeOfAShadow) {
    // Nodes in the dark have next to nothing, and slopes take it away wherever they count.
    const auto shadow = [](const Vec3& p) {
        const double light = p.x < 0.5 ? 1e-9 : p.x - 0.5;
        return Rgb{light, 2.0 * light, 0.0};
    };
    std::vector<Rgb> at_nodes;
    const NodalField field = plane_of(square(8, 0.4), shadow, at_nodes);
    const Values values = field.fit(at_nodes);
    const std::vector<Vec3> points = square(50, 0.0);
    std::vector<std::vector<Interpolation::Weight>> weights(points.size());
    std::vector<NodalField::Place> places;
    for (std::size_t p = 0; p < points.size(); ++p) {
        field.interpolation().at(points[p], up, 0, weights[p]);
        places.push_back({points[p], up, 1.0 + points[p].y, Span<Interpolation::Weight>(weights[p])});
    }
    const std::vector<Rgb> found =
        field.at_conservatively(values, places.size(), [&](std::size_t p) { return places[p]; });
    double sum = 0.0, expected = 0.0;
    for (std::size_t p = 0; p < places.size(); ++p) {
        Rgb constant;
        for (const Interpolation::Weight& w : weights[p]) constant += w.weight * at_nodes[w.site];
        for (int c = 0; c < 2; ++c) {
            // Twice by slopes, and twice by what makes up for them.
            ASSERT_GE(found[p][c], 0.25 * constant[c]) << p;
            ASSERT_LE(found[p][c], 4.0 * constant[c]) << p;
        }
        EXPECT_EQ(found[p].z, 0.0);
        sum += places[p].area * found[p].y;
        expected += places[p].area * constant.y;
    }
    EXPECT_NEAR(sum, expected, 1e-12 * expected);
}

TEST(NodalField, ConstantsOfItsTuningCount) {
    const auto bend = [](const Vec3& p) { return Rgb{p.x * p.x, 1.0, 0.0}; };
    std::vector<Rgb> at_nodes;
    const std::vector<Vec3> nodes = square(8, 0.4);
    for (const Vec3& p : nodes) at_nodes.push_back(bend(p));
    const auto with = [&](const NodalTuning& tuning) {
        const NodalField field(nodes, std::vector<Vec3>(nodes.size(), up), std::vector<std::uint32_t>(nodes.size(), 0),
                               {}, tuning);
        const Values values = field.fit(at_nodes);
        const Vec3 point{0.3, 0.52, 0.0};
        std::vector<Interpolation::Weight> weights;
        field.interpolation().at(point, up, 0, weights);
        Rgb constant;
        for (const Interpolation::Weight& w : weights) constant += w.weight * at_nodes[w.site];
        const auto place = [&](std::size_t) {
            return NodalField::Place{point, up, 1.0, Span<Interpolation::Weight>(weights)};
        };
        return std::array<double, 3>{value_at(field, values, point, up).x,
                                     field.at_conservatively(values, 1, place)[0].x, constant.x};
    };
    const auto usual = with({});
    NodalTuning tuning;
    tuning.slope_neighbors = 18.0;
    EXPECT_NE(with(tuning)[0], usual[0]);
    tuning = {};
    tuning.most_sloped = 1.0;  // weights alone
    EXPECT_NEAR(with(tuning)[1], usual[2], 1e-12);
}

}  // namespace
}  // namespace surflux
