#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "basis_functions.h"
#include "shapes.h"
#include "surflux/core/sampling.h"
#include "surflux/meshless/point_placement.h"
#include "surflux/meshless/surfel_means.h"

namespace surflux {
namespace {

// A scene with points placed on it, on three levels, and the means of their functions.
struct Placed {
    explicit Placed(const Scene& of, double radius = 0.0, std::uint64_t seed = 1)
        : scene(of),
          tracer(scene),
          points(scene.surfels),
          placement(scene, tracer, {radius, 5}),
          sight(scene, tracer, basis) {
        means = std::make_unique<SurfelMeans>(scene, tracer, points, basis, sight, placement.points().first_radius,
                                              SurfelMeans::Options{3, 1.0, seed}, Progress{});
        for (std::size_t level = 0; level < 3; ++level) {
            placement.add_level();
            const PlacedPoints& p = placement.points();
            const auto from = static_cast<std::ptrdiff_t>(p.level_begin[level]);
            basis.add_level({p.positions.begin() + from, p.positions.end()},
                            {p.normals.begin() + from, p.normals.end()}, {p.objects.begin() + from, p.objects.end()});
            sight.extend({}, Progress{});
            means->extend(level, Progress{});
        }
    }
    Scene scene;
    Tracer tracer;
    SurfelPoints points;
    PointPlacement placement;
    MultilevelBasis basis;
    BasisSight sight;
    std::unique_ptr<SurfelMeans> means;
};

// The coarsest functions make a slope, the finer ones waves.
std::vector<Rgb> some_field(const MultilevelBasis& basis) {
    std::vector<Rgb> out(basis.size());
    for (std::uint32_t j = 0; j < basis.size(); ++j) {
        const Vec3& p = basis.position(j);
        const double waves = 0.1 * std::sin(9.0 * p.x + 4.0 * p.y - 7.0 * p.z);
        out[j] = basis.level_of(j) == 0 ? Rgb{1.0 + p.x, 2.0 - p.y, 1.0} : Rgb{waves, -waves, 0.0};
    }
    return out;
}

Scene box_and_ball() {
    Scene scene;
    Surfels walls = shapes::cube_inside(4, 0.5, 0.0), ball = shapes::sphere(400, 0.2, 1.0, 0.5, 0.0, {0.5, 0.5, 0.5});
    append(scene, walls);
    append(scene, ball);
    return scene;
}

TEST(SurfelMeans, AreTheMeansOfTheBasisOverPatchesAndItsValueAtDisks) {
    const Placed of(box_and_ball());
    const std::vector<Rgb> field = some_field(of.basis);
    const Surfels& s = of.scene.surfels;
    double squared = 0.0;
    std::size_t patches = 0;
    for (std::uint32_t i = 0; i < s.size(); ++i) {
        ASSERT_EQ(of.means->outside(i), 1.0);
        const Rgb mean = of.means->mean(i, field);
        EXPECT_NEAR(mean.z, 1.0, 1e-6);  // weights sum to 1
        if (!of.points.is_patch(i)) {
            const Rgb value = shapes::evaluate(of.basis, s.positions[i], s.normals[i], of.scene.object[i], field);
            EXPECT_NEAR(mean.x, value.x, 1e-5) << i;
            EXPECT_NEAR(mean.y, value.y, 1e-5) << i;
            continue;
        }
        EvenPoints even(2, 99, i);
        Rgb expected;
        for (int k = 0; k < 1024; ++k) {
            const double* u = even.next();
            expected +=
                shapes::evaluate(of.basis, of.points.at(i, u[0], u[1]), s.normals[i], of.scene.object[i], field);
        }
        squared += std::pow(mean.x - expected.x / 1024.0, 2.0);
        ++patches;
    }
    ASSERT_EQ(patches, 96u);
    EXPECT_LT(std::sqrt(squared / static_cast<double>(patches)), 8e-3);  // of values about 1.5, of which waves are .1
}

// The unit square of parts x parts patches, on whose middle a closed box stands, w wide.
Scene box_on_the_floor(int parts, double w) {
    Surfels s;
    const double at = 0.5 - 0.5 * w;
    const Vec3 x{w, 0, 0}, y{0, w, 0}, z{0, 0, 0.4}, o{at, at, -0.1};
    shapes::add_rectangle(s, {}, {1, 0, 0}, {0, 1, 0}, parts, parts);
    shapes::add_rectangle(s, o, y, x, 1, 1);
    shapes::add_rectangle(s, o + z, x, y, 1, 1);
    shapes::add_rectangle(s, o, x, z, 1, 1);
    shapes::add_rectangle(s, o + y, z, x, 1, 1);
    shapes::add_rectangle(s, o, z, y, 1, 1);
    shapes::add_rectangle(s, o + x, y, z, 1, 1);
    shapes::finish(s, 0.5, 0.0);
    Scene scene;
    append(scene, s);
    return scene;
}

TEST(SurfelMeans, LeaveOutWhatIsInsideGeometry) {
    for (const int parts : {1, 8})
        for (const double w : {0.2, 0.35, 0.5})
            for (std::uint64_t seed = 0; seed < 4; ++seed) {
                const Placed of(box_on_the_floor(parts, w), 0.2, seed);
                const auto floors = static_cast<std::uint32_t>(parts * parts);
                std::vector<Rgb> field(of.basis.size());
                std::fill(field.begin(), field.begin() + of.basis.first(1), Rgb{1, 1, 1});
                double outside = 0.0;
                for (std::uint32_t i = 0; i < floors; ++i) {
                    outside += of.means->outside(i) / floors;
                    EXPECT_NEAR(of.means->mean(i, field).x, of.means->outside(i), 1e-6);
                }
                EXPECT_NEAR(outside, 1.0 - w * w, 0.035) << parts << ' ' << w << ' ' << seed;
            }
}

TEST(SurfelMeans, SeeNarrowPeaksOnWidePatches) {
    const Placed of(box_on_the_floor(1, 0.2), 0.4);
    ASSERT_TRUE(of.means->is_wide(0));
    std::vector<Rgb> field(of.basis.size());
    double sum = 0.0;
    for (std::uint32_t j = 0; j < of.basis.first(1); ++j)
        field[j].x = std::exp(-30.0 * length_squared(of.basis.position(j) - Vec3{0.15, 0.15, 0}));
    const int n = 64;
    for (int k = 0; k < n * n; ++k) {
        const Vec3 p{(k % n + 0.5) / n, (k / n + 0.5) / n, 0};
        if (std::max(std::abs(p.x - 0.5), std::abs(p.y - 0.5)) > 0.1)
            sum += shapes::evaluate(of.basis, p, {0, 0, 1}, 0, field).x / (n * n);
    }
    ASSERT_GT(sum, 0.01);
    EXPECT_NEAR(of.means->mean(0, field).x, sum, 0.05 * sum);
}

TEST(SurfelMeans, AreOfLittleUseWhereSurfelsAreWiderThanTheCoarsestSpacing) {
    const Placed of(box_and_ball(), 0.3);
    for (std::uint32_t i = 0; i < of.scene.surfels.size(); ++i)
        EXPECT_EQ(of.means->is_wide(i), of.points.is_patch(i));  // .35 across; disks are one place
    const Placed coarse(box_and_ball(), 0.4);
    for (std::uint32_t i = 0; i < coarse.scene.surfels.size(); ++i) EXPECT_FALSE(coarse.means->is_wide(i));
}

}  // namespace
}  // namespace surflux
