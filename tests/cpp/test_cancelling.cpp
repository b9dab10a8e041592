#include <gtest/gtest.h>

#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/neighbors/point_index.h"
#include "surflux/neighbors/sheet_index.h"
#include "surflux/scene/surfels.h"
#include "surflux/solution/interpolation.h"
#include "surflux/solution/regions.h"

namespace surflux {
namespace {

// Passes over all surfels that begin a stage, each of which may take a second of millions of them: so they ask, too,
// whether to go on.
struct Pass {
    std::string name;
    std::function<void(const Progress&)> run;
};

Surfels square(std::size_t count) {
    Surfels out;
    Random random(1);
    for (std::size_t i = 0; i < count; ++i) out.positions.push_back({random.uniform(), random.uniform(), 0.0});
    out.normals.assign(count, {0.0, 0.0, 1.0});
    out.radii.assign(count, 0.01);
    out.areas.assign(count, 1.0 / static_cast<double>(count));
    out.reflectance = Colors(count, {0.5, 0.5, 0.5});
    out.emission = Colors(count, {});
    return out;
}

TEST(Cancelling, EveryPassThatBeginsAStageAsksWhetherToGoOn) {
    const std::size_t count = 100000;
    const Surfels s = square(count);
    const std::vector<std::uint32_t> object(count, 0);
    const std::vector<Rgb> light(count, Rgb{1, 1, 1});
    std::vector<std::uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0u);
    const Pass passes[] = {
        {"morton_order", [&](const Progress& p) { morton_order(s.positions, p); }},
        {"PointIndex", [&](const Progress& p) { PointIndex(s.positions, p); }},
        {"SheetIndex", [&](const Progress& p) { SheetIndex(s.positions, s.normals, s.radii, object, 0.8, p); }},
        {"Interpolation", [&](const Progress& p) { Interpolation(s.positions, s.normals, object, p); }},
        {"select", [&](const Progress& p) { select(s, all, p); }},
        {"Regions", [&](const Progress& p) { Regions(s, light, 10, p); }},
    };
    for (const Pass& pass : passes) {
        std::size_t asked = 0;
        pass.run([&](std::size_t done, std::size_t total) {
            EXPECT_LE(done, total) << pass.name;
            return ++asked > 0;
        });
        EXPECT_GE(asked, 2u) << pass.name;
        // At the first report, and at one on the way.
        for (const std::size_t at : {std::size_t{1}, asked / 2 + 1}) {
            std::size_t reports = 0;
            EXPECT_THROW(pass.run([&](std::size_t, std::size_t) { return ++reports < at; }), Cancelled) << pass.name;
            EXPECT_EQ(reports, at) << pass.name;
        }
    }
}

TEST(Cancelling, WhereAPassStandsIsToldToLoopsThatCountSomethingElse) {
    std::vector<std::pair<std::size_t, std::size_t>> told;
    const Progress standing = standing_at(3, 7, [&](std::size_t done, std::size_t total) {
        told.emplace_back(done, total);
        return told.size() < 2;
    });
    EXPECT_TRUE(standing(100, 200));
    EXPECT_FALSE(standing(101, 200));
    EXPECT_EQ(told, (std::vector<std::pair<std::size_t, std::size_t>>{{3, 7}, {3, 7}}));
    EXPECT_FALSE(standing_at(3, 7, {}));  // nobody asks
}

}  // namespace
}  // namespace surflux
