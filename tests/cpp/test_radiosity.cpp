#include <gtest/gtest.h>

#include "shapes.h"
#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/radiosity/closure.h"
#include "surflux/radiosity/exchange.h"
#include "surflux/radiosity/solve.h"
#include "surflux/solution/conjugate_gradients.h"

namespace surflux {
namespace {

using shapes::scene_of;

// Sum of F_ij over two ranges of surfels, averaged over the first by area.
double factor_between(const Exchange& e, std::size_t from, std::size_t from_end, std::size_t to, std::size_t to_end) {
    double exchange = 0.0, area = 0.0;
    for (std::size_t i = from; i < from_end; ++i) {
        area += e.areas[i];
        for (std::size_t j = to; j < to_end; ++j) exchange += e.scale[i] * e.at(i, j) * e.scale[j];
    }
    return exchange / area;
}

TEST(Exchange, UnitCubeMatchesTheClosedFormBeforeAnyClosure) {
    const int n = 12;
    const Scene scene = scene_of({shapes::cube_inside(n, 0.5, 0.0)});
    const Exchange e = exchange_of_all_pairs(scene, nullptr, {}, 0);
    const std::size_t face = n * n;
    // Between opposite faces the midpoint rule is off by O((h / r)^2), h = 1/12 and r = 1; near pairs have closed
    // forms.
    EXPECT_NEAR(factor_between(e, 0, face, face, 2 * face), 0.1998248957, 0.5 / 144.0 * 0.2);
    for (std::size_t k = 2; k < 6; ++k)
        EXPECT_NEAR(factor_between(e, 0, face, k * face, (k + 1) * face), 0.2000437761, 2e-3 * 0.2);
    EXPECT_EQ(factor_between(e, 0, face, 0, face), 0.0);
}

TEST(Exchange, ParallelRectanglesMatchTheClosedForm) {
    // 1 x 2 at distance .5: .5089886690. The escape is measured, and does not spoil it.
    Surfels low, high;
    shapes::add_rectangle(low, {0, 0, 0}, {1, 0, 0}, {0, 2, 0}, 8, 16);
    shapes::add_rectangle(high, {0, 0, 0.5}, {0, 2, 0}, {1, 0, 0}, 16, 8);
    shapes::finish(low, 0.5, 0.0);
    shapes::finish(high, 0.5, 0.0);
    const Scene scene = scene_of({low, high});
    const Tracer tracer(scene);
    Exchange e = exchange_of_all_pairs(scene, &tracer, {}, 0);
    EXPECT_NEAR(factor_between(e, 0, 128, 128, 256), 0.5089886690, 2e-3 * 0.509);
    Hemispheres h = measure_hemispheres(scene, tracer, 256, 0);
    const Closure closure = close(e, h);
    EXPECT_LT(closure.residual, 1e-7);
    EXPECT_NEAR(factor_between(e, 0, 128, 128, 256), 0.5089886690, 2e-3 * 0.509);
}

TEST(Exchange, InsideASphereEveryPairHasItsShareOfTheArea) {
    // F_ij = A_j / (4 pi R^2) for every pair, i = j included; nothing occludes.
    const Scene scene = scene_of({shapes::sphere(600, 2.0, -1.0, 0.5, 0.0)});
    const Tracer tracer(scene);
    Exchange e = exchange_of_all_pairs(scene, &tracer, {}, 0);
    Hemispheres h = measure_hemispheres(scene, tracer, 64, 0);
    close(e, h);
    double total = 0.0;
    for (double area : e.areas) total += area;
    for (std::size_t i = 0; i < e.size; ++i)
        for (std::size_t j = 0; j < e.size; ++j) {
            const double factor = e.scale[i] * e.at(i, j) * e.scale[j] / e.areas[i];
            ASSERT_NEAR(factor / (e.areas[j] / total), 1.0, 0.02) << i << " " << j;
        }
}

TEST(Exchange, IsSymmetricClosedAndTheSameForAnyNumberOfThreads) {
    const Surfels ball = shapes::sphere(200, 0.2, 1.0, 0.5, 0.0, {0.4, 0.5, 0.2});  // rests on the floor
    const Scene scene = scene_of({shapes::cube_inside(6, 0.5, 0.0), ball});
    const Tracer tracer(scene);
    Exchange e = exchange_of_all_pairs(scene, &tracer, {}, 3);
    Hemispheres h = measure_hemispheres(scene, tracer, 64, 3);
    {
        const ThreadLimit one(1);
        EXPECT_EQ(exchange_of_all_pairs(scene, &tracer, {}, 3).g, e.g);
        EXPECT_EQ(measure_hemispheres(scene, tracer, 64, 3).absorbed, h.absorbed);
    }
    EXPECT_LT(close(e, h).residual, 1e-7);
    for (std::size_t i = 0; i < e.size; ++i) {
        double row = h.escape[i] + h.absorbed[i];
        for (std::size_t j = 0; j < e.size; ++j) {
            ASSERT_EQ(e.g[i * e.size + j], e.g[j * e.size + i]);
            ASSERT_GE(e.g[i * e.size + j], 0.0f);
            row += e.scale[i] * e.at(i, j) * e.scale[j] / e.areas[i];
        }
        ASSERT_NEAR(row, 1.0, 1e-6);
    }
}

TEST(Exchange, WhereNoDiagonalClosesItNoRowIsTooLargeAndWhatIsLackingIsAbsorbed) {
    // All that each of the two sees is the other, but one has twice the area: d_0 G d_1 cannot be both 1 and 2.
    Exchange e;
    e.size = 3;
    e.areas = {1.0, 2.0, 1.0};
    e.scale.assign(3, 1.0);
    e.sure.assign(3, 0);
    e.g = {0.0f, 0.9f, 0.0f, 0.9f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    Hemispheres h;
    h.escape = {0.0, 0.0, 0.0};
    h.absorbed = {0.0, 0.0, 0.0};  // the third sees nothing at all
    h.taken.assign(3, 256);
    const Closure closure = close(e, h);
    EXPECT_LT(closure.residual, 1e-7);
    EXPECT_NEAR(closure.largest_shortfall, 1.0, 1e-12);  // of the third
    EXPECT_NEAR(e.scale[0] * e.at(0, 1) * e.scale[1], 1.0, 1e-6);
    EXPECT_NEAR(h.absorbed[0], 0.0, 1e-6);
    EXPECT_NEAR(h.absorbed[1], 0.5, 1e-6);
    EXPECT_NEAR(h.absorbed[2], 1.0, 1e-12);
}

TEST(Exchange, DisksInContactStayFinite) {
    // Coincident and facing each other: everything goes across. A gap of 1e-3 of the radius: nearly everything.
    for (double gap : {0.0, 1e-3}) {
        const Scene scene =
            scene_of({shapes::disk({0, 0, 0}, {0, 0, 1}, 1.0), shapes::disk({0, 0, gap}, {0, 0, -1}, 1.0)});
        const Tracer tracer(scene);
        const Exchange e = exchange_of_all_pairs(scene, &tracer, {}, 0);
        EXPECT_TRUE(std::isfinite(e.g[1]));
        EXPECT_LE(e.at(0, 1), e.areas[0] * (1.0 + 1e-6));
        EXPECT_GE(e.at(0, 1), (gap > 0.0 ? 0.95 : 0.0) * e.areas[0]);
    }
}

TEST(Exchange, OfDisksIsThatOfThePartsThatFaceEachOther) {
    // The centre of the upright one lies under the other's plane, a part of it above: nothing is in the way of that.
    const Scene scene =
        scene_of({shapes::disk({0, 0, 0}, {0, 0, 1}, 0.1), shapes::disk({0.6, 0, -0.02}, {-1, 0, 0}, 0.1)});
    const Tracer tracer(scene);
    const double open = exchange_of_all_pairs(scene, nullptr, {}, 0).at(0, 1);
    EXPECT_GT(open, 0.0);
    EXPECT_NEAR(exchange_of_all_pairs(scene, &tracer, {}, 0).at(0, 1), open, 1e-6 * open);
}

TEST(Exchange, RefusesMorePairsThanTheMemoryTakes) {
    ExchangeOptions options;
    options.max_memory = 1000.0;
    const Scene scene = scene_of({shapes::cube_inside(3, 0.5, 0.0)});
    try {
        exchange_of_all_pairs(scene, nullptr, options, 0);
        FAIL() << "54 surfels need 11664 bytes";
    } catch (const ArgumentError& error) {
        EXPECT_NE(std::string(error.what()).find("at most 15 surfels fit"), std::string::npos) << error.what();
    }
}

TEST(Exchange, CancelsWhenToldTo) {
    const Scene scene = scene_of({shapes::cube_inside(8, 0.5, 0.0)});
    EXPECT_THROW(exchange_of_all_pairs(scene, nullptr, {}, 0, [](std::size_t, std::size_t) { return false; }),
                 Cancelled);
}

TEST(ConjugateGradients, SolveEachChannelToItsResidual) {
    // Tridiagonal (-1, 2.5, -1), two channels, one of them all zero.
    const std::size_t n = 50;
    const LinearOperator apply = [n](const std::vector<double>& x, std::vector<double>& out) {
        out.resize(2 * n);
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t c = 0; c < 2; ++c)
                out[2 * i + c] =
                    2.5 * x[2 * i + c] - (i > 0 ? x[2 * i - 2 + c] : 0.0) - (i + 1 < n ? x[2 * i + 2 + c] : 0.0);
    };
    std::vector<double> b(2 * n, 0.0), x, product;
    for (std::size_t i = 0; i < n; ++i) b[2 * i] = std::sin(double(i));
    const LinearReport report = conjugate_gradients(apply, b, 2, 1e-10, 1000, x);
    apply(x, product);
    for (std::size_t k = 0; k < b.size(); ++k) EXPECT_NEAR(product[k], b[k], 1e-9);
    EXPECT_LE(report.residual, 1e-10);
    for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(x[2 * i + 1], 0.0);
}

TEST(Solve, EnergyBalancesInAnOpenScene) {
    Surfels floor;
    shapes::add_rectangle(floor, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 8, 8);
    shapes::finish(floor, 0.7, 0.0);
    const Scene scene =
        scene_of({floor, shapes::sphere(300, 0.2, 1.0, 0.4, 0.0, {0.5, 0.5, 0.3})},
                 {PointLight{{0.5, 0.2, 2}, {5, 4, 3}}, Environment{{0.2, 0.3, 0.4}, 0, 0, {}, {0, 0, 1}}});
    const Solution solution = solve(scene, {});
    const auto figure = [&](const char* name) {
        for (const auto& [key, value] : solution.history.at(0))
            if (key == name) return value;
        throw std::out_of_range(name);
    };
    const double in = figure("power_in");
    EXPECT_NEAR(figure("power_absorbed") + figure("power_escaped") + figure("power_into_backs"), in, 1e-4 * in);
    EXPECT_GT(figure("power_escaped"), 0.2 * in);
}

TEST(Solve, GreyScenesAreSolvedInOneChannel) {
    const auto channels = [](const Surfels& s) {
        const Solution solution = solve(scene_of({s}), {});
        for (const auto& [name, value] : solution.history.at(0))
            if (name == "channels") return value;
        return 0.0;
    };
    Surfels s = shapes::cube_inside(3, 0.5, 1.0);
    EXPECT_EQ(channels(s), 1.0);
    std::vector<Rgb> reflectance(s.size(), {0.5, 0.5, 0.5});
    reflectance[0].x = 0.6;
    s.reflectance = reflectance;
    EXPECT_EQ(channels(s), 3.0);
}

TEST(Solve, AWallBetweenTwoRoomsLetsNothingThrough) {
    // Two unit rooms side by side; a wall of disks between them, 20 x 20 and two-sided; light in the first one.
    Surfels room;
    const Vec3 x{2, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, o;
    shapes::add_rectangle(room, o, x, y, 12, 6);
    shapes::add_rectangle(room, z, y, x, 6, 12);
    shapes::add_rectangle(room, o, y, z, 6, 6);
    shapes::add_rectangle(room, x, z, y, 6, 6);
    shapes::add_rectangle(room, o, z, x, 6, 12);
    shapes::add_rectangle(room, y, x, z, 12, 6);
    shapes::finish(room, 0.7, 0.0);
    Surfels wall;
    const int n = 20;
    for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) {
            wall.positions.push_back({1.0, (a + 0.5) / n, (b + 0.5) / n});
            wall.normals.push_back({1, 0, 0});
        }
    shapes::finish(wall, 0.7, 0.0);
    wall.radii.assign(wall.positions.size(), 0.71 / n);
    wall.areas.assign(wall.positions.size(), 1.0 / (n * n));
    const Scene scene = scene_of({room, two_sided(wall)}, {PointLight{{0.5, 0.5, 0.9}, {1, 1, 1}}});
    SolveOptions options;
    options.insert = false;  // inserted surfels take their light from all around
    const Solution solution = solve(scene, options);
    double lit = 0.0, dark = 0.0;
    for (std::size_t i = 0; i < solution.surfels.size(); ++i) {
        const Vec3& p = solution.surfels.positions[i];
        const bool second = p.x > 1.0 || (p.x == 1.0 && solution.surfels.normals[i].x > 0.0);
        (second ? dark : lit) += solution.surfels.areas[i] * solution.irradiance[i].x;
    }
    EXPECT_GT(lit, 1.0);
    EXPECT_LT(dark, 1e-4 * lit);
}

TEST(Solve, RefusesWhatItCannotSolve) {
    EXPECT_THROW(solve(Scene{}, {}), ArgumentError);
    Surfels s = shapes::cube_inside(2, 0.5, 1.0);
    SolveOptions options;
    options.tolerance = 0.0;
    EXPECT_THROW(solve(scene_of({s}), options), ArgumentError);
    s.areas[3] = 0.0;
    EXPECT_THROW(solve(scene_of({s}), {}), ArgumentError);
    s.areas.clear();
    EXPECT_THROW(solve(scene_of({s}), {}), ArgumentError);
}

}  // namespace
}  // namespace surflux
