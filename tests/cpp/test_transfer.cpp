#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "shapes.h"
#include "surflux/lights/sample_points.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/group_light.h"
#include "surflux/transfer/group_oracle.h"
#include "surflux/transfer/local_transfer.h"
#include "surflux/transfer/sender_groups.h"
#include "surflux/transfer/test_lights.h"
#include "surflux/transfer/transport_operator.h"

namespace surflux {
namespace {

SenderGroups::Lit alike(const std::uint32_t*, std::size_t, std::uint64_t) { return {1.0f}; }

TEST(SenderGroups, AreAPartitionWithMeansByArea) {
    const Scene scene = shapes::sphere_inside(2000);
    const std::vector<double>& areas = scene.surfels.areas;
    const SenderGroups groups(scene, areas, std::vector<double>(areas.size(), 1.0), 300, alike, {}, {});
    ASSERT_EQ(groups.leaves.size(), 300u);
    ASSERT_EQ(groups.size(), 599u);
    std::vector<double> area(groups.size(), 0.0);
    for (std::size_t i = 0; i < areas.size(); ++i) {
        ASSERT_TRUE(groups.nodes[groups.leaf_of_surfel[i]].is_leaf());
        area[groups.leaf_of_surfel[i]] += areas[i];
    }
    for (std::uint32_t k = 0; k < groups.size(); ++k) {
        const SenderGroups::Node& node = groups.nodes[k];
        if (node.is_leaf()) {
            EXPECT_NEAR(static_cast<double>(node.area), area[k], 1e-5);
            EXPECT_GT(node.area, 0.0f);
        } else {
            EXPECT_GT(node.child, k);
            EXPECT_NEAR(node.area, groups.nodes[node.child].area + groups.nodes[node.child + 1].area, 1e-4);
        }
    }
    // The mean of x over all of the sphere is that of the root.
    std::vector<Rgb> x;
    for (const Vec3& p : scene.surfels.positions) x.push_back({p.x + 1.0, 1.0, 0.0});
    std::vector<float> values = groups.means(x, areas);
    groups.pull_up(values, colors);
    EXPECT_NEAR(values[0], 1.0f, 1e-3);
    EXPECT_NEAR(values[1], 1.0f, 1e-5);
}

TEST(SenderGroups, ASenderIsAsLargeAsTheReachAndFacesOneWay) {
    const Scene scene = shapes::sphere_inside(2000);
    const SenderGroups groups(scene, scene.surfels.areas, std::vector<double>(2000, 1.0), 500, alike, {}, {});
    for (std::uint32_t i = 0; i < 2000; i += 37) {
        EXPECT_EQ(groups.sender(i, 0.0), groups.leaf_of_surfel[i]);
        const SenderGroups::Node& far = groups.nodes[groups.sender(i, 0.5)];
        EXPECT_LE(far.radius, 0.5f);
        EXPECT_GT(far.area, 4.0f * groups.nodes[groups.leaf_of_surfel[i]].area);
        EXPECT_GE(groups.nodes[groups.sender(i, 10.0)].alike, 0.8f);  // never the whole sphere
    }
}

TEST(SenderGroups, SamplesLieOnTheirGroups) {
    const Scene scene = shapes::sphere_inside(500);
    const SenderGroups groups(scene, scene.surfels.areas, std::vector<double>(500, 1.0), 60, alike, {}, {});
    const SenderSamples samples = sample_senders(scene, SurfelPoints(scene.surfels), scene.surfels.areas, groups, 4, 7);
    ASSERT_EQ(samples.samples.size(), 240u);
    for (std::size_t k = 0; k < 240; ++k) {
        const std::uint32_t surfel = samples.samples[k].surfel;
        EXPECT_EQ(groups.leaf_of_surfel[surfel], groups.leaves[k / 4]);
        EXPECT_LT(length(samples.position(k) - scene.surfels.positions[surfel]), 0.2);
        EXPECT_NEAR(dot(samples.normal(k), scene.surfels.normals[surfel]), 1.0, 1e-6);
    }
}

TEST(GroupLight, IsTheInverseSquareWithOneRayForEachAndWithFewer) {
    const CompiledScene compiled(shapes::sphere_inside(2000));
    const Scene& scene = compiled.scene();
    const SenderGroups groups(scene, scene.surfels.areas, std::vector<double>(2000, 1.0), 400, alike, {}, {});
    const SenderSamples samples = sample_senders(scene, SurfelPoints(scene.surfels), scene.surfels.areas, groups, 4, 7);
    const std::vector<float> white(colors * groups.size(), 1.0f);
    const SurfelPoints points(scene.surfels);
    const GroupLight light(compiled, groups, samples, points, scene.surfels.areas);
    for (const std::size_t rays : {4000u, 100u}) {
        const std::vector<float> found = light.irradiance({PointLight{{0, 0, 0}, {2, 0, 1}}}, white, {rays, 3});
        for (const std::uint32_t leaf : groups.leaves) {
            EXPECT_NEAR(found[colors * leaf], 2.0f, 0.03f);  // also of groups that share a ray
            EXPECT_EQ(found[colors * leaf + 1], 0.0f);
            EXPECT_FLOAT_EQ(found[colors * leaf + 2], 0.5f * found[colors * leaf]);
        }
    }
}

TEST(GroupLight, WhereNothingOccludesFewRaysSayWhatManyDo) {
    // Close to a wall, but not so close that disks share its light: of most groups all that they would send is less
    // than what a ray stands for.
    const CompiledScene compiled(shapes::sphere_inside(4000));
    const Surfels& s = compiled.scene().surfels;
    const SenderGroups groups(compiled.scene(), s.areas, std::vector<double>(s.size(), 1.0), 1000, alike, {}, {});
    const SenderSamples samples = sample_senders(compiled.scene(), SurfelPoints(s), s.areas, groups, 4, 7);
    const std::vector<float> white(colors * groups.size(), 1.0f);
    const SurfelPoints points(s);
    const GroupLight light(compiled, groups, samples, points, s.areas);
    const std::vector<Light> lamp{PointLight{{0.0, 0.0, 0.85}, {1, 2, 3}}};
    const std::vector<float> many = light.irradiance(lamp, white, {10000, 0});
    for (const std::uint64_t seed : {0u, 1u, 2u}) {
        const std::vector<float> few = light.irradiance(lamp, white, {50, seed});
        for (const std::uint32_t leaf : groups.leaves) {
            EXPECT_GT(few[colors * leaf], 0.0f);
            EXPECT_FLOAT_EQ(few[colors * leaf], many[colors * leaf]);
        }
    }
}

// A closed house on a ground that goes on beneath it, whose groups are neighbours of those around.
struct ClosedHouse {
    static constexpr double x0 = -0.3, y0 = -0.45, x1 = 0.35, y1 = 0.2, height = 0.5;
    CompiledScene compiled;

    explicit ClosedHouse(int across, double half = 1.0) : compiled(made(across, half)) {}
    const Surfels& surfels() const { return compiled.scene().surfels; }
    std::uint32_t of_ground(int across) const { return static_cast<std::uint32_t>(across * across); }
    static bool is_inside(const Vec3& p) {
        return p.x > x0 && p.x < x1 && p.y > y0 && p.y < y1 && p.z >= 0.0 && p.z < height;
    }
    static Scene made(int across, double half) {
        Surfels ground, house;
        shapes::add_rectangle(ground, {-half, -half, 0}, {2 * half, 0, 0}, {0, 2 * half, 0}, across, across);
        const Vec3 low{x0, y0, 0.0}, high{x1, y1, height}, x{x1 - x0, 0, 0}, y{0, y1 - y0, 0}, z{0, 0, height};
        shapes::add_rectangle(house, low, z, x, 1, 1);
        shapes::add_rectangle(house, low, y, z, 1, 1);
        shapes::add_rectangle(house, high, -x, -z, 1, 1);
        shapes::add_rectangle(house, high, -z, -y, 1, 1);
        shapes::add_rectangle(house, high, -y, -x, 1, 1);
        shapes::finish(ground, 0.5, 0.0);
        shapes::finish(house, 0.5, 0.0);
        return shapes::scene_of({ground, house});
    }
    SenderGroups groups(std::size_t leaves, std::uint64_t seed) const {
        const Surfels& s = surfels();
        const SurfelPoints points(s);
        const GroupOracle oracle(s, points, compiled.tracer(), false, seed);
        const auto unlikeness = [&](const std::uint32_t* members, std::size_t count, std::uint64_t stream) {
            return oracle.unlikeness(members, count, stream);
        };
        return SenderGroups(compiled.scene(), s.areas, std::vector<double>(s.size(), 1.0), leaves, unlikeness,
                            oracle.walls(true), {});
    }
};

TEST(GroupLight, WallsPartGroupsThatShareARay) {
    const ClosedHouse house(40);
    const Surfels& s = house.surfels();
    const SurfelPoints points(s);
    const SenderGroups groups = house.groups(s.size(), 5);
    ASSERT_EQ(groups.leaves.size(), s.size());
    const SenderSamples samples = sample_senders(house.compiled.scene(), points, s.areas, groups, 4, 7);
    const std::vector<float> white(colors * groups.size(), 1.0f);
    const GroupLight light(house.compiled, groups, samples, points, s.areas);
    for (const std::uint64_t seed : {0u, 1u, 2u}) {
        for (const bool across : {false, true}) {
            const std::vector<float> found =
                light.irradiance({DirectionalLight{{0, 0, -1}, {1, 1, 1}}}, white, {200, seed, true, across});
            double most_inside = 0.0, sum = 0.0;
            for (std::uint32_t i = 0; i < house.of_ground(40); ++i) {
                const auto of_leaf = static_cast<double>(found[colors * groups.leaf_of_surfel[i]]);
                sum += s.areas[i] * of_leaf;
                if (ClosedHouse::is_inside(s.positions[i])) most_inside = std::max(most_inside, of_leaf);
            }
            const double around = 4.0 - 0.65 * 0.65;
            EXPECT_NEAR(sum, around, 0.1 * around);
            EXPECT_EQ(most_inside, across ? 1.0 : 0.0);
        }
    }
}

// A lamp close over a corner of the ground: what walls make of the rest would send hardly any of what a ray stands for.
TEST(GroupLight, RaysOfLittleLightAreDrawnAndCountForOthers) {
    const ClosedHouse house(40);
    const Surfels& s = house.surfels();
    const SurfelPoints points(s);
    const SenderGroups groups = house.groups(s.size(), 5);
    const SenderSamples samples = sample_senders(house.compiled.scene(), points, s.areas, groups, 4, 7);
    const std::vector<float> white(colors * groups.size(), 1.0f);
    const GroupLight light(house.compiled, groups, samples, points, s.areas);
    const std::vector<Light> lamp{PointLight{{0.9, 0.9, 0.1}, {1, 1, 1}}};
    const std::vector<float> wanted = light.irradiance(lamp, white, {1u << 20, 0});
    constexpr int seeds = 200;
    double sum = 0.0, all = 0.0;
    int for_others = 0;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        const std::vector<float> found = light.irradiance(lamp, white, {200, seed});
        for (std::uint32_t i = 0; i < house.of_ground(40); ++i) {
            const std::size_t k = colors * groups.leaf_of_surfel[i];
            const bool is_inside = ClosedHouse::is_inside(s.positions[i]);
            EXPECT_TRUE(found[k] == 0.0f || !is_inside);
            const double distance = length(Vec3{0.9, 0.9, 0.1} - s.positions[i]);
            const double free = 0.1 / (distance * distance * distance);
            EXPECT_LE(found[k], 4.4 * free);
            for_others += found[k] > 1.5 * free;
            if (!(s.positions[i].x < ClosedHouse::x0)) continue;
            sum += static_cast<double>(found[k]);
            all += static_cast<double>(wanted[k]);
        }
    }
    EXPECT_GT(for_others, 10 * seeds);
    EXPECT_NEAR(sum / all, 1.0, 0.03);
}

TEST(SenderGroups, NoneHasBothSidesOfAWall) {
    // Of 16 and 32 surfels in the mean, where the floor of the house is two of them.
    const ClosedHouse house(48, 1.5);
    const Surfels& s = house.surfels();
    for (const std::uint64_t seed : {0u, 1u, 2u})
        for (const std::size_t each : {16u, 32u}) {
            const SenderGroups groups = house.groups(s.size() / each, seed);
            ASSERT_EQ(groups.leaves.size(), s.size() / each);
            std::vector<int> inside(groups.size(), 0), around(groups.size(), 0);
            for (std::uint32_t i = 0; i < house.of_ground(48); ++i)
                ++(ClosedHouse::is_inside(s.positions[i]) ? inside : around)[groups.leaf_of_surfel[i]];
            for (std::uint32_t k = static_cast<std::uint32_t>(groups.size()); k-- > 0;) {
                const SenderGroups::Node& node = groups.nodes[k];
                if (inside[k] > 0 && around[k] > 0) {
                    EXPECT_FALSE(node.is_leaf()) << inside[k] << " and " << around[k];
                    EXPECT_TRUE(node.is_walled());
                }
                if (k > 0) inside[node.parent] += inside[k], around[node.parent] += around[k];
            }
        }
}

TEST(TransportOperator, RowsOfAClosedSphereAreComplete) {
    const CompiledScene compiled(shapes::sphere_inside(1500));
    Figures timings;
    const TransportOperator found = build_operator(compiled, {}, {}, timings);
    std::vector<float> sent(found.senders.size(), 1.0f), values, coefficients, received;
    found.gather(sent, 1, values);
    for (const float value : values) EXPECT_NEAR(value, 1.0f, 1e-5);
    found.coefficients(values, 1, coefficients);
    found.receive(coefficients, 1, received);
    for (const std::uint32_t leaf : found.senders.leaves) EXPECT_NEAR(received[leaf], 1.0f, 1e-4);
    EXPECT_GT(found.bytes(), 6 * found.links.size());
    for (const float share : found.losses()) EXPECT_EQ(share, 0.0f);
}

// Corners need finer levels.
TransportOperator operator_of_a_room() {
    Scene room;
    append(room, shapes::cube_inside(20, 0.5, 0.0));
    const CompiledScene compiled(room);
    OperatorOptions options;
    options.epsilon = 0.02;
    Figures timings;
    return build_operator(compiled, options, {}, timings);
}

TEST(TransportOperator, ReflectionsGoByWayOfTheFirstLevelsAndOwnRows) {
    // Reflections leave finer levels out.
    const TransportOperator found = operator_of_a_room();
    const std::size_t levels = found.level_begin.size() - 1, end = found.level_begin[found.bounce_end()];
    ASSERT_EQ(found.bounce_end(), 3u);
    ASSERT_GT(levels, 4u);
    std::vector<float> sent(found.senders.size(), 0.0f), all, part, of_all, of_part, by_all, by_part;
    for (std::size_t k = 0; k < sent.size(); ++k) sent[k] = static_cast<float>(k % 7);
    found.gather(sent, 1, all);
    found.gather(sent, 1, part, TransportOperator::Part::bounces);
    found.coefficients(all, 1, of_all);
    found.coefficients(part, 1, of_part, TransportOperator::Part::bounces);
    const std::size_t own = found.level_begin[levels - 1];
    EXPECT_LT(end, own);
    for (std::size_t j = 0; j < of_all.size(); ++j) EXPECT_EQ(of_part[j], j < end || j >= own ? of_all[j] : 0.0f);
    for (const SparseRows::Entry& entry : found.at_groups.entries)
        EXPECT_TRUE(entry.column < end || entry.column >= own);
    found.receive(of_all, 1, by_all);
    found.receive(of_part, 1, by_part);
    EXPECT_EQ(by_all, by_part);
}

// Colors are gathered four links at once, of which rows have any number.
TEST(TransportOperator, ColorsAreGatheredAsAnyOtherChannels) {
    const TransportOperator found = operator_of_a_room();
    std::set<std::uint32_t> left;
    for (const TransportOperator::Row& row : found.rows) left.insert((row.end - row.begin) % 4);
    EXPECT_EQ(left.size(), 4u);
    std::vector<float> sent(colors * found.senders.size());
    for (std::size_t k = 0; k < sent.size(); ++k) sent[k] = static_cast<float>(1 + k % 11);
    for (const auto part : {TransportOperator::Part::all, TransportOperator::Part::bounces}) {
        std::vector<float> together;
        found.gather(sent, colors, together, part);
        for (std::size_t c = 0; c < colors; ++c) {
            std::vector<float> one(found.senders.size()), apart;
            for (std::size_t k = 0; k < one.size(); ++k) one[k] = sent[colors * k + c];
            found.gather(one, 1, apart, part);
            for (std::size_t k = 0; k < apart.size(); ++k)
                EXPECT_NEAR(together[colors * k + c], apart[k], 1e-5f * apart[k]);
        }
    }
    std::vector<float> tilted, together;
    found.gather_tilted(sent, tilted);
    found.gather(sent, colors, together);
    for (std::size_t k = 0; k < found.rows.size(); ++k)
        for (std::size_t c = 0; c < 3; ++c) {
            const float value = tilted[TransportOperator::tilted_channels * k + c];
            EXPECT_NEAR(value, together[colors * k + c], 1e-5f * value);
        }
}

// A beam between the samples of all leaves: one of them has its light, and a ray from where it is lit.
TEST(GroupLight, ANarrowBeamIsAllOnItsPatch) {
    const CompiledScene compiled(shapes::scene_of({shapes::cube_inside(6, 0.5, 0.0)}));
    const Surfels& s = compiled.scene().surfels;
    const SenderGroups groups(compiled.scene(), s.areas, std::vector<double>(s.size(), 1.0), 5000, alike, {}, {});
    const SurfelPoints points(s);
    const SenderSamples samples = sample_senders(compiled.scene(), points, s.areas, groups, 4, 7);
    const std::vector<float> white(colors * groups.size(), 1.0f);
    const GroupLight light(compiled, groups, samples, points, s.areas);
    SpotLight spot;
    spot.position = {0.5, 0.5, 0.6};
    spot.intensity = {1, 1, 1};
    spot.cone = 0.5, spot.penumbra = 0.0;
    for (const Vec3& towards : {Vec3{0.1, 0.03, -1.0}, Vec3{0.31, -0.2, -1.0}, Vec3{1.0, 0.2, 0.1}}) {
        spot.direction = normalized(towards);
        const std::vector<float> found = light.irradiance({spot}, white, {1000, 0});
        double power = 0.0;
        for (const std::uint32_t leaf : groups.leaves)
            power += static_cast<double>(groups.nodes[leaf].area) * static_cast<double>(found[colors * leaf]);
        EXPECT_NEAR(power / (2.0 * pi * (1.0 - std::cos(0.25 * pi / 180.0))), 1.0, 1e-4);
    }
}

TEST(TestLights, ThereMayBeNone) {
    const CompiledScene compiled(shapes::sphere_inside(300));
    Figures timings;
    const TransportOperator found = build_operator(compiled, {}, {}, timings);
    ShotRows rows;
    rows.rows.resize(7);
    const SurfelPoints points(compiled.scene().surfels);
    const GroupLight light(compiled, found.senders, found.samples, points, found.areas);
    TestLights none(light, found.senders, rows, std::vector<float>(colors * found.senders.size(), 0.5f), {}, {}, 0, {});
    TestLights::Received received;
    none.receive(rows, received);
    none.normalize(received, std::vector<double>(rows.rows.size(), 1.0));
    EXPECT_EQ(none.size(), 0u);
    for (const float variance : received.variance) EXPECT_EQ(variance, 0.0f);
}

TEST(TransportOperator, LinksHaveTheSlopesOfTheirRays) {
    // Light that comes from one side alone tilts: by its gradient, a normal that turns there receives more.
    const CompiledScene compiled(shapes::sphere_inside(3000));
    Figures timings;
    const TransportOperator found = build_operator(compiled, {}, {}, timings);
    std::vector<float> values;
    std::vector<Rgb> half;
    for (const Vec3& p : compiled.scene().surfels.positions) half.push_back({p.x > 0.0 ? 1.0 : 0.0, 0.0, 0.0});
    std::vector<float> sent = found.senders.means(half, found.areas);
    found.senders.pull_up(sent, colors);
    found.gather_tilted(sent, values);
    int turned = 0;
    for (std::size_t k = 0; k < found.positions.size(); ++k) {
        if (std::abs(found.positions[k].z) < 0.9) continue;  // at the poles, where x is in the tangent plane
        EXPECT_GT(values[TransportOperator::tilted_channels * k + 3], 0.2f);
        EXPECT_NEAR(values[TransportOperator::tilted_channels * k], 0.5f, 0.1f);
        ++turned;
    }
    EXPECT_GT(turned, 5);
}

}  // namespace
}  // namespace surflux
