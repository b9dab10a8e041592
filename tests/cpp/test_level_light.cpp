#include "surflux/meshless/level_light.h"

#include <gtest/gtest.h>

using namespace surflux;

namespace {

// Two levels on the plane z = 0 around the origin. What coarser functions say there hangs on which the place sees, so
// that fine ones beside each other correct what is not said at other places.
MeshlessField two_levels(const std::vector<MeshlessField::At>& coarse, const std::vector<MeshlessField::At>& fine,
                         const std::vector<Rgb>& corrections) {
    MeshlessField field;
    for (const auto* level : {&coarse, &fine}) {
        const std::vector<Vec3> places(level->size(), Vec3{}), normals(level->size(), Vec3{0, 0, 1});
        SupportOptions support;
        support.radii.assign(level->size(), 1.0);
        field.basis.add_level(places, normals, std::vector<std::uint32_t>(level->size(), 0), support);
        for (std::size_t k = 0; k < level->size(); ++k) {
            const MeshlessField::At& value = (*level)[k];
            field.values.push_back(value);
            field.coefficients.push_back(level == &coarse ? value.all : corrections[k]);
            field.direct.push_back(level == &coarse ? value.direct : 0.5 * corrections[k]);
            field.gathered.push_back(1);
        }
    }
    return field;
}

MeshlessField::At grey(double all) { return {{all, all, all}, {0.5 * all, 0.5 * all, 0.5 * all}}; }

}  // namespace

TEST(LevelLight, WhatIsOnItsLevelAloneIsBlended) {
    const MeshlessField field = two_levels({grey(1.0), grey(3.0)}, {}, {});
    MeshlessField::At light;
    LevelLight(field, {{0, 0.25}, {1, 0.75}}).add_to(light);
    for (int c = 0; c < 3; ++c) {
        EXPECT_DOUBLE_EQ(light.all[c], 2.5);
        EXPECT_DOUBLE_EQ(light.direct[c], 1.25);
    }
}

// A ramp: coarse functions have the slope, fine ones hardly correct it, and L07 eq. 9 holds as it stands.
TEST(LevelLight, KeepsTheSlopeOfCoarserLevels) {
    const MeshlessField field =
        two_levels({grey(1.0)}, {grey(0.9), grey(1.1)}, {{0.02, 0.02, 0.02}, {-0.01, -0.01, -0.01}});
    MeshlessField::At light = grey(1.05);  // at the place itself
    LevelLight(field, {{1, 0.5}, {2, 0.5}}).add_to(light);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(light.all[c], 1.05 + 0.5 * (0.02 - 0.01), 1e-15);
        EXPECT_NEAR(light.direct[c], 0.5 * light.all[c], 1e-15);
    }
}

// Behind a curtain fine functions found 1 all around; one of them sees a coarse function that says .1 there, and this
// place one that says 1: by eq. 9 it would have 1 + .9 / 2. And the other way round 1 - .9 / 2.
TEST(LevelLight, JumpsOfCoarserLevelsAreNoSlopes) {
    for (const double said : {0.1, 1.9}) {
        const double off = 1.0 - said;
        const MeshlessField field = two_levels({grey(1.0)}, {grey(1.0), grey(1.0)}, {{off, off, off}, {}});
        MeshlessField::At light = grey(1.0);
        LevelLight(field, {{1, 0.5}, {2, 0.5}}).add_to(light);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(light.all[c], 1.0, 0.1 + 1e-12) << said;
    }
}

// Where it is dark, values may be a little less than 0, from weights that are.
TEST(LevelLight, ValuesBelowNothingAreNumbers) {
    const MeshlessField field = two_levels({grey(-1e-9)}, {}, {});
    MeshlessField::At light;
    LevelLight(field, {{0, 1.0}}).add_to(light);
    EXPECT_EQ(light.all.x, -1e-9);
    EXPECT_EQ(light.direct.x, -5e-10);
}

// Its color is not changed by a limit of a channel.
TEST(LevelLight, ColorsOfSlopesAreKept) {
    const MeshlessField field = two_levels({grey(1.0)}, {grey(1.0)}, {{0.9, 0.0, -0.3}});
    MeshlessField::At light = grey(1.0);
    LevelLight(field, {{1, 1.0}}).add_to(light);
    EXPECT_NEAR(light.all.x, 1.1, 1e-12);
    EXPECT_NEAR(light.all.y, 1.0, 1e-12);
    EXPECT_NEAR(light.all.z, 1.0 - 0.1 / 3.0, 1e-12);
}

// At the rim of a finer level, and where light was gathered for some of its functions, coarser ones keep their part.
TEST(LevelLight, OthersKeepTheirShare) {
    MeshlessField field = two_levels({grey(1.0)}, {grey(2.0), grey(7.0)}, {{1, 1, 1}, {}});
    field.gathered[2] = 0;
    field.values[2] = {};
    MeshlessField::At light = grey(1.0);
    LevelLight(field, {{1, 0.3}, {2, 0.3}}).add_to(light);
    EXPECT_NEAR(light.all.x, 0.7 * 1.0 + 0.3 * 2.0, 1e-12);
    LevelLight(field, {}).add_to(light);
    EXPECT_NEAR(light.all.x, 0.7 * 1.0 + 0.3 * 2.0, 1e-12);
}
