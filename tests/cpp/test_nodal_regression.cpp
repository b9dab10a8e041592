#include <gtest/gtest.h>

#include <cmath>

#include "shapes.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/solution/nodal_regression.h"

namespace surflux {
namespace {

const Vec3 up{0, 0, 1};

// Jittered nodes on a floor of one metre, and a wall across it at x = .5 where one is wanted.
struct Floor {
    explicit Floor(bool wall = false) : scene(make(wall)), tracer(scene), sight(tracer, scene), nodes(places()) {}

    static Scene make(bool wall) {
        Surfels floor, across;
        shapes::add_rectangle(floor, {}, {1, 0, 0}, {0, 1, 0}, 10, 10);
        shapes::finish(floor, 0.5, 0.0);
        if (!wall) return shapes::scene_of({floor});
        shapes::add_rectangle(across, {0.5, 0, 0}, {0, 1, 0}, {0, 0, 1}, 1, 1);
        shapes::finish(across, 0.5, 0.0);
        return shapes::scene_of({floor, across});
    }
    static NodalField places() {
        std::vector<Vec3> at;
        Random random(5, 0);
        for (int a = 0; a < side; ++a)
            for (int b = 0; b < side; ++b) {
                const double x = (a + 0.3 + 0.4 * random.uniform()) / side;
                at.push_back({x, (b + 0.3 + 0.4 * random.uniform()) / side, 0.0});
            }
        return {at, std::vector<Vec3>(at.size(), up), std::vector<std::uint32_t>(at.size(), 0)};
    }
    // What is left of noise of that standard deviation, over it: RMS, and the largest.
    template <class F>
    std::pair<double, double> left(const F& f, double noise, std::uint64_t seed = 1) const {
        std::vector<Rgb> values;
        std::vector<double> errors;
        Random random(seed, 0);
        const auto normal = [&] {
            double sum = -6.0;
            for (int k = 0; k < 12; ++k) sum += random.uniform();
            return sum;
        };
        for (const Vec3& p : nodes.positions()) {
            values.push_back((f(p) + noise * normal()) * warm);
            errors.push_back(noise * std::abs(normal()) * color_norm(warm));
        }
        const std::vector<Rgb> found = without_noise(nodes, values, errors, sight);
        double squared = 0.0, largest = 0.0;
        for (std::size_t k = 0; k < found.size(); ++k) {
            const double off = (found[k].y / warm.y - f(nodes.positions()[k])) / noise;
            squared += off * off / static_cast<double>(found.size());
            largest = std::max(largest, std::abs(off));
        }
        return {std::sqrt(squared), largest};
    }

    static constexpr int side = 40;
    const Rgb warm{1, 0.5, 0.25};
    Scene scene;
    Tracer tracer;
    Sight sight;
    NodalField nodes;
};

double waves(const Vec3& p) { return 2.0 + std::cos(5.0 * p.x) * std::sin(4.0 * p.y); }

TEST(NodalRegression, TakesHalfOfTheNoiseOffASmoothField) {
    const Floor floor;
    for (const std::uint64_t seed : {1u, 2u, 3u}) EXPECT_LT(floor.left(waves, 0.05, seed).first, 0.55) << seed;
}

TEST(NodalRegression, KeepsWhatStandsOutOfTheNoise) {
    const Floor floor;
    // An edge of ten standard deviations, and ripples as narrow as four nodes.
    const auto edge = [](const Vec3& p) { return p.x < 0.52 ? 1.0 : 1.5; };
    const auto ripples = [](const Vec3& p) { return 2.0 + std::sin(2.0 * pi * p.x * 10.0); };
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
        EXPECT_LT(floor.left(edge, 0.05, seed).first, 0.6) << seed;
        EXPECT_LT(floor.left(edge, 0.05, seed).second, 4.0) << seed;
        EXPECT_LT(floor.left(ripples, 0.05, seed).first, 1.05) << seed;
    }
}

TEST(NodalRegression, TakesNothingFromBeyondAWall) {
    // A hundredth of the light, and of the noise: a few of the other side's nodes would be all there is.
    const Floor parted(true);
    // Nor light of another colour that is as bright.
    const Rgb white{1, 1, 1}, red{1.0, 0.2, 0.2}, green{0.2, luminance(red - Rgb{0, 0.2, 0}) / 0.7152 - 0.06, 0.2};
    for (const auto& [left, right] : {std::pair(white, 0.01 * white), std::pair(red, green)}) {
        std::vector<Rgb> values;
        std::vector<double> errors;
        for (const Vec3& p : parted.nodes.positions()) {
            values.push_back(p.x < 0.5 ? left : right);
            errors.push_back(0.05 * color_norm(values.back()));
        }
        const std::vector<Rgb> found = without_noise(parted.nodes, values, errors, parted.sight);
        for (std::size_t k = 0; k < found.size(); ++k)
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[k][c] / values[k][c], 1.0, 1e-9) << parted.nodes.positions()[k].x;
    }
}

TEST(NodalRegression, KeepsColoursThatAreAsBright) {
    // Red and green of one luminance, on either side of an edge, with noise of a twentieth.
    const Floor floor;
    const Rgb red{1.0, 0.2, 0.2}, green{0.2, luminance(Rgb{0.8, 0.2, 0.0}) / 0.7152, 0.2};
    std::vector<Rgb> values, truth;
    std::vector<double> errors;
    Random random(4, 0);
    for (const Vec3& p : floor.nodes.positions()) {
        truth.push_back(p.x < 0.52 ? red : green);
        const double off = 0.05 * (2.0 * random.uniform() - 1.0) * std::sqrt(3.0);
        values.push_back((1.0 + off) * truth.back());
        errors.push_back(0.05 * color_norm(truth.back()) * std::sqrt(3.0) * random.uniform());
    }
    const std::vector<Rgb> found = without_noise(floor.nodes, values, errors, floor.sight);
    for (std::size_t k = 0; k < found.size(); ++k)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[k][c] / truth[k][c], 1.0, 0.25) << floor.nodes.positions()[k].x;
}

TEST(NodalRegression, IsTheSameInAnyUnit) {
    const Floor floor;
    const auto found_in = [&](double unit) {
        std::vector<Rgb> values;
        std::vector<double> errors;
        Random random(6, 0);
        for (const Vec3& p : floor.nodes.positions()) {
            values.push_back(unit * (waves(p) + 0.1 * random.uniform()) * Rgb{1, 1, 1});
            errors.push_back(unit * 0.1 * random.uniform());
        }
        return without_noise(floor.nodes, values, errors, floor.sight);
    };
    const std::vector<Rgb> usual = found_in(1.0);
    for (const double unit : {0x1p-300, 0x1p300}) {
        const std::vector<Rgb> found = found_in(unit);
        for (std::size_t k = 0; k < found.size(); ++k) EXPECT_EQ(found[k], unit * usual[k]);
    }
}

TEST(NodalRegression, ChangesNothingThatIsSure) {
    const Floor floor;
    std::vector<Rgb> values;
    for (const Vec3& p : floor.nodes.positions()) values.push_back(waves(p) * Rgb{1, 1, 1});
    EXPECT_EQ(without_noise(floor.nodes, values, std::vector<double>(values.size(), 0.0), floor.sight), values);
}

}  // namespace
}  // namespace surflux
