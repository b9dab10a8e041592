#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "shapes.h"
#include "surflux/core/sampling.h"
#include "surflux/meshless/point_placement.h"
#include "surflux/meshless/surfel_means.h"

namespace surflux {
namespace {

// A scene with points placed on it, on three levels, and the means of their functions.
struct Placed {
    explicit Placed(const Scene& of, double radius = 0.0)
        : scene(of), tracer(scene), points(scene.surfels), placement(scene, tracer, {radius, 1000, 5}) {
        means = std::make_unique<SurfelMeans>(scene, tracer, points, basis, placement.points().first_radius, 3, 1,
                                              Progress{});
        for (std::size_t level = 0; level < 3; ++level) {
            placement.add_level();
            const PlacedPoints& p = placement.points();
            const auto from = static_cast<std::ptrdiff_t>(p.level_begin[level]);
            basis.add_level({p.positions.begin() + from, p.positions.end()},
                            {p.normals.begin() + from, p.normals.end()}, {p.objects.begin() + from, p.objects.end()});
            means->extend(level, Progress{});
        }
    }
    Scene scene;
    Tracer tracer;
    SurfelPoints points;
    PointPlacement placement;
    MultilevelBasis basis;
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
            const Rgb value = of.basis.evaluate(s.positions[i], s.normals[i], of.scene.object[i], field);
            EXPECT_NEAR(mean.x, value.x, 1e-5) << i;
            EXPECT_NEAR(mean.y, value.y, 1e-5) << i;
            continue;
        }
        EvenPoints even(2, 99, i);
        Rgb expected;
        for (int k = 0; k < 1024; ++k) {
            const double* u = even.next();
            expected += of.basis.evaluate(of.points.at(i, u[0], u[1]), s.normals[i], of.scene.object[i], field);
        }
        squared += std::pow(mean.x - expected.x / 1024.0, 2.0);
        ++patches;
    }
    ASSERT_EQ(patches, 96u);
    EXPECT_LT(std::sqrt(squared / static_cast<double>(patches)), 8e-3);  // of values about 1.5, of which waves are .1
}

TEST(SurfelMeans, LeaveOutWhatIsInsideGeometry) {
    // A closed box stands on a quarter of the floor.
    for (const int parts : {1, 8}) {
        Surfels s;
        const Vec3 x{0.5, 0, 0}, y{0, 0.5, 0}, z{0, 0, 0.4}, o{0.25, 0.25, -0.1};
        shapes::add_rectangle(s, {}, {1, 0, 0}, {0, 1, 0}, parts, parts);
        const auto floors = static_cast<std::uint32_t>(s.size());
        shapes::add_rectangle(s, o, y, x, 1, 1);
        shapes::add_rectangle(s, o + z, x, y, 1, 1);
        shapes::add_rectangle(s, o, x, z, 1, 1);
        shapes::add_rectangle(s, o + y, z, x, 1, 1);
        shapes::add_rectangle(s, o, z, y, 1, 1);
        shapes::add_rectangle(s, o + x, y, z, 1, 1);
        shapes::finish(s, 0.5, 0.0);
        Scene scene;
        append(scene, s);
        const Placed of(scene, 0.2);
        const std::vector<Rgb> ones(of.basis.first(1), {1, 1, 1});
        std::vector<Rgb> field(of.basis.size());
        std::copy(ones.begin(), ones.end(), field.begin());
        double outside = 0.0;
        for (std::uint32_t i = 0; i < floors; ++i) {
            outside += of.means->outside(i) / floors;
            EXPECT_NEAR(of.means->mean(i, field).x, of.means->outside(i), 1e-6);
            if (parts == 1) continue;
            const Vec3& p = s.positions[i];
            const bool below = p.x > 0.25 && p.x < 0.75 && p.y > 0.25 && p.y < 0.75;
            EXPECT_EQ(of.means->outside(i), below ? 0.0 : 1.0);
        }
        EXPECT_NEAR(outside, 0.75, parts == 1 ? 0.03 : 1e-12);
    }
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
