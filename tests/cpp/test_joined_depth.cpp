#include "surflux/render/joined_depth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "splat_pictures.h"

namespace surflux {
namespace {

std::vector<float> depths(const Surfels& surfels) {
    std::vector<Box> boxes;
    for (const Triangle& t : surfels.triangles) {
        Box box{t.a, t.a};
        for (const Vec3* corner : {&t.b, &t.c})
            for (int axis = 0; axis < 3; ++axis) {
                box.low[axis] = std::min(box.low[axis], (*corner)[axis]);
                box.high[axis] = std::max(box.high[axis], (*corner)[axis]);
            }
        boxes.push_back(box);
    }
    return joined_depths(surfels, BoxTree(boxes), reaches(surfels));
}

TEST(JoinedDepths, OfFlatSheetsAreNoneHoweverCloseAnotherIs) {
    Surfels sheets;
    add_square(sheets, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 4);
    add_square(sheets, {0.3, 0.3, 0.02}, {0.5, 0, 0}, {0, 0.5, 0}, 2);
    for (const float depth : depths(sheets)) EXPECT_NEAR(depth, 0.0f, 1e-6f);
}

TEST(JoinedDepths, AreThoseOfCornersThatTouchAlsoInTheMiddleOfAnEdge) {
    Surfels roof;  // a square, and beside it one of half the size, which rises by 45 degrees
    add_square(roof, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1);
    add_square(roof, {1, 0.2, 0}, {0.4, 0, 0.4}, {0, 0.5, 0}, 1);
    EXPECT_NEAR(depths(roof)[0], 0.4f, 1e-6f);
    EXPECT_NEAR(depths(roof)[1], std::sqrt(0.5f), 1e-6f);
}

TEST(JoinedDepths, AreNoneOfWhatNothingTouchesOrStandsAtAnAngle) {
    Surfels apart;
    add_square(apart, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1);
    add_square(apart, {1.1, 0, 0}, {1, 0, 0}, {0, 1, 0}, 1);
    add_square(apart, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 1);  // a wall
    add_disk(apart, {0.5, 0.5, 0}, {0, 0, 1}, 0.5);
    EXPECT_EQ(depths(apart)[0], 0.0f);
    EXPECT_EQ(depths(apart)[1], 0.0f);
    EXPECT_TRUE(std::isinf(depths(apart)[3]));  // of a disk it is not known
}

}  // namespace
}  // namespace surflux
