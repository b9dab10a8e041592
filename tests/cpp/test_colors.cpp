#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "surflux/scene/colors.h"

namespace surflux {
namespace {

std::vector<Rgb> of(std::size_t count, std::size_t different) {
    std::vector<Rgb> out;
    for (std::size_t i = 0; i < count; ++i) {
        const auto k = static_cast<double>(i * 7 % different);
        out.push_back({k, 0.1 * k, 1.0 / (1.0 + k)});
    }
    return out;
}

TEST(Colors, AreThoseThatWereGivenHoweverMany) {
    for (const std::size_t different : {1, 2, 255, 256, 257, 5000}) {
        const std::vector<Rgb> given = of(6000, different);
        const Colors colors = given;
        ASSERT_EQ(colors.size(), given.size());
        for (std::size_t i = 0; i < given.size(); ++i) ASSERT_TRUE(colors[i] == given[i]) << different << " " << i;
        EXPECT_EQ(colors.palette().size(), different <= 256 ? different : given.size());
        std::size_t at = 0;
        for (const Rgb& color : colors) ASSERT_TRUE(color == given[at++]);
        EXPECT_EQ(at, given.size());
    }
}

TEST(Colors, AreAppended) {
    for (const std::size_t different : {3, 200, 1000}) {
        const std::vector<Rgb> first = of(1000, 3), second = of(1500, different);
        Colors colors = first;
        colors.append(second);
        ASSERT_EQ(colors.size(), 2500u);
        for (std::size_t i = 0; i < 2500; ++i) ASSERT_TRUE(colors[i] == (i < 1000 ? first[i] : second[i - 1000]));
    }
    EXPECT_TRUE(Colors().empty());
    EXPECT_EQ(Colors(3, {1, 2, 3}).palette().size(), 1u);
}

TEST(Colors, KeepTheSignOfZero) {
    Colors colors;
    for (const double zero : {0.0, -0.0, 0.0}) colors.push_back({zero, 0.0, 0.0});
    EXPECT_FALSE(std::signbit(colors[0].x));
    EXPECT_TRUE(std::signbit(colors[1].x));
    EXPECT_FALSE(std::signbit(colors[2].x));
}

}  // namespace
}  // namespace surflux
