#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "shapes.h"
#include "surflux/core/float_sum.h"
#include "surflux/core/random.h"
#include "surflux/lights/sample_points.h"
#include "surflux/trace/compiled_scene.h"
#include "surflux/transfer/group_oracle.h"
#include "surflux/transfer/own_rows.h"
#include "surflux/transfer/places_in_air.h"
#include "surflux/transfer/sparse_rows.h"

namespace surflux {
namespace {

// Its numbers are what they are.
class Numbers final : public RowTest {
public:
    explicit Numbers(std::size_t size) : RowTest(size, 1.0f) {}

private:
    void find(const ShotRows&, std::size_t, std::size_t, float*) const override {}
};

TEST(GroupOracle, SurfelsNearEachOtherAreLitAlikeAndThoseAcrossAreNot) {
    const CompiledScene compiled(shapes::sphere_inside(3000));
    const Surfels& s = compiled.scene().surfels;
    const SurfelPoints points(s);
    const GroupOracle oracle(s, points, compiled.tracer(), false, 5);
    std::vector<std::uint32_t> cap, all(s.size());
    for (std::uint32_t i = 0; i < s.size(); ++i)
        if (s.positions[i].z > 0.99) cap.push_back(i);
    std::iota(all.begin(), all.end(), 0u);
    ASSERT_GT(cap.size(), 5u);
    float near = 0.0f, across = 0.0f;
    for (std::uint64_t stream = 0; stream < 50; ++stream) {
        near += oracle.unlikeness(cap.data(), cap.size(), stream).unlike / 50.0f;
        across += oracle.unlikeness(all.data(), all.size(), stream).unlike / 50.0f;
    }
    EXPECT_LT(near, 0.25f);
    EXPECT_GT(across, 0.5f);
    EXPECT_LE(across, 1.0f);
}

TEST(GroupOracle, NothingDistantIsSeenFromInsideAndAllIsFromOutside) {
    const CompiledScene inside(shapes::sphere_inside(1000));
    std::vector<std::uint32_t> all(1000);
    std::iota(all.begin(), all.end(), 0u);
    const Surfels& s = inside.scene().surfels;
    EXPECT_EQ(GroupOracle(s, SurfelPoints(s), inside.tracer(), true, 5).unlikeness(all.data(), all.size(), 0).unlike,
              0.0f);
    Scene ball;
    append(ball, shapes::sphere(1000, 1.0, 1.0, 0.5, 0.0));
    const CompiledScene outside(ball);
    const Surfels& t = outside.scene().surfels;
    EXPECT_GT(GroupOracle(t, SurfelPoints(t), outside.tracer(), true, 5).unlikeness(all.data(), all.size(), 0).unlike,
              0.3f);
}

TEST(GroupOracle, SurfelsAtOnePlaceAreFinite) {
    Scene scene = shapes::sphere_inside(1000);
    for (int k = 0; k < 20; ++k) scene.surfels.positions[static_cast<std::size_t>(k)] = scene.surfels.positions[0];
    const CompiledScene compiled(scene);
    const Surfels& s = compiled.scene().surfels;
    const SurfelPoints points(s);
    std::vector<std::uint32_t> same(20);
    std::iota(same.begin(), same.end(), 0u);
    for (std::uint64_t stream = 0; stream < 100; ++stream) {
        const float found =
            GroupOracle(s, points, compiled.tracer(), false, 5).unlikeness(same.data(), same.size(), stream).unlike;
        EXPECT_TRUE(found >= 0.0f && found <= 1.0f) << found;
    }
}

TEST(PlacesInAir, KeepClearOfSurfacesWhereThereIsRoom) {
    const CompiledScene compiled(shapes::sphere_inside(3000));
    const Surfels& s = compiled.scene().surfels;
    const SurfelPoints points(s);
    std::vector<Place> receivers;
    for (std::uint32_t i = 0; i < s.size(); ++i) receivers.push_back({s.positions[i], s.normals[i], i});
    const std::vector<double> air(s.size(), 1.0);
    for (const double clearance : {0.0, 0.4, 50.0}) {  // the last leaves no room but when it is halved
        const std::vector<Vec3> found = places_in_air(points, compiled.tracer(), receivers, air, {}, clearance, 200, 3);
        ASSERT_EQ(found.size(), 200u);
        for (const Vec3& p : found) EXPECT_LT(length(p), clearance == 0.4 ? 0.65 : 1.0);
    }
    const Box region{{0.5, -1, -1}, {1, 1, 1}};
    for (const Vec3& p : places_in_air(points, compiled.tracer(), receivers, air, region, 0.05, 50, 3))
        EXPECT_GE(p.x, 0.5);
}

TEST(OwnRows, ClustersAreHalvedWhereTheirMembersDiffer) {
    const Scene scene = shapes::sphere_inside(2000);
    const std::vector<double>& areas = scene.surfels.areas;
    const Numbers test(2);
    ContradictedSurfels off;
    for (std::uint32_t i = 0; i < scene.surfels.size(); i += 2) {  // of one number on each side
        const float side = scene.surfels.positions[i].x > 0.0 ? 1.0f : 2.0f;
        off.surfels.push_back(i);
        off.variance.push_back(0.0f);
        off.error.push_back(1.0);
        off.received.insert(off.received.end(), {side, side});
    }
    const auto clusters = cluster_alike(scene, areas, off, test, {0.1, 16, 128, 400}, {});
    EXPECT_GT(clusters.size(), 1u);
    EXPECT_LT(clusters.size(), 400u);
    std::vector<std::uint32_t> members;
    for (const Cluster& cluster : clusters) {
        members.insert(members.end(), cluster.members.begin(), cluster.members.end());
        EXPECT_EQ(cluster.middle % 2, 0u);
        const auto right = std::count_if(cluster.members.begin(), cluster.members.end(),
                                         [&](std::uint32_t k) { return off.received[2 * k] == 1.0f; });
        const double share = static_cast<double>(right) / static_cast<double>(cluster.members.size());
        EXPECT_LT(share * (1.0 - share), 0.012);  // the variance that is allowed, and areas are not quite alike
    }
    std::sort(members.begin(), members.end());
    ASSERT_EQ(members.size(), off.surfels.size());  // each in one cluster
    for (std::uint32_t k = 0; k < members.size(); ++k) EXPECT_EQ(members[k], k);
    EXPECT_EQ(cluster_alike(scene, areas, off, test, {0.1, 16, 128, 3}, {}).size(), 3u);
    EXPECT_TRUE(cluster_alike(scene, areas, off, test, {0.1, 16, 128, 0}, {}).empty());
    off.variance.assign(off.variance.size(), 10.0f);  // what rays do not know is no difference
    EXPECT_EQ(cluster_alike(scene, areas, off, test, {0.1, 16, 128, 400}, {}).size(), 1u);
}

template <class Sum>
void expect_sums(Sum sum, std::size_t count) {
    std::vector<float> found(count), expected(count, 0.0f), values(count);
    Random random(1, 2);
    for (int k = 0; k < 20; ++k) {
        for (float& value : values) value = static_cast<float>(random.uniform());
        sum.add(0.25f * static_cast<float>(k), values.data());
        for (std::size_t c = 0; c < count; ++c) expected[c] += 0.25f * static_cast<float>(k) * values[c];
    }
    sum.write(found.data());
    for (std::size_t c = 0; c < count; ++c) {
        EXPECT_NEAR(found[c], expected[c], 1e-4);
        EXPECT_EQ(found[c], sum.data()[c]);
    }
}

TEST(FloatSum, OfAnyNumberIsWhatALoopSays) {
    for (const std::size_t count : {0u, 1u, 3u, 4u, 7u, 12u})
        with_fixed(count, [&](const auto channels) { expect_sums(float_sum(channels), count); });
    expect_sums(Float4Sum<16>(), 16);
}

}  // namespace
}  // namespace surflux
