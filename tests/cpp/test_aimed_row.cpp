#include <gtest/gtest.h>

#include <cmath>

#include "small_strip.h"
#include "surflux/radiosity/gathering.h"

namespace surflux {
namespace {

// The small strip sends light, of 1.
struct Gap {
    Scene scene;
    Tracer tracer{scene};
    SurfelTree tree{scene, build_hierarchy(scene.surfels, scene.object, {}), scene.surfels.size()};
    LightSampler skies{scene, LightSampler::usual_small_emitters, LightSampler::Sources::constant_sky};
    SurfelPoints points{scene.surfels};
    std::vector<double> sent = std::vector<double>(tree.size(), 0.0);

    Gap() : scene(small_strip()) {
        for (std::size_t i = 0; i < scene.surfels.size(); ++i) sent[i] = scene.object[i] == 1 ? 1.0 : 0.0;
        tree.pull_up(sent, 1);
    }
    double gathered(const Gathering& rows, std::size_t row) const {
        double out = 0.0;
        rows.gather(row, sent, 1, &out);
        return out;
    }
};

// Whatever rays were aimed at, they are the whole hemisphere: links, what escapes and what backs absorb make 1.
TEST(AimedRow, RowsMakeOne) {
    const Gap gap;
    Gathering rows(gap.points, gap.tracer, gap.tree, gap.skies, 0);
    const std::vector<Place> floor(places_of(gap.scene.surfels));
    rows.add(floor, std::vector<int>(floor.size(), 256));
    rows.add_aimed(floor, std::vector<int>(floor.size(), 1024), [&](std::size_t k, std::vector<Aim>& aims) {
        rows.aims_of(k, gap.sent, 1, floor[k].position, aims);
    });
    for (std::size_t k = floor.size(); k < rows.size(); ++k) {
        const Gathering::Row& row = rows.row(k);
        double sum = row.escape + row.absorbed;
        rows.for_senders(k, [&](std::uint32_t, double share) { sum += share; });
        EXPECT_NEAR(sum, 1.0, 1e-6);
        EXPECT_TRUE(row.is_aimed());
    }
}

// Over 64 seeds the mean is that of plain rays, which see as much of the strip on average; the variance is less
// than that of as many plain rays by far.
TEST(AimedRow, IsUnbiasedAndSeesWhatIsSmall) {
    const Gap gap;
    const std::vector<Place> one{places_of(gap.scene.surfels)[105]};
    constexpr int seeds = 64;
    double mean[2] = {}, squared[2] = {};
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        Gathering rows(gap.points, gap.tracer, gap.tree, gap.skies, seed);
        rows.add(one, {1024});
        rows.add_aimed(one, {1024}, [&](std::size_t, std::vector<Aim>& aims) {
            rows.aims_of(0, gap.sent, 1, one[0].position, aims);
        });
        EXPECT_LT(rows.row(1).rays, 2u * 1024u);
        for (std::size_t k = 0; k < 2; ++k) {
            const double h = gap.gathered(rows, k);
            mean[k] += h / seeds;
            squared[k] += h * h / seeds;
        }
    }
    double variance[2];
    for (int k = 0; k < 2; ++k) variance[k] = squared[k] - mean[k] * mean[k];
    EXPECT_GT(mean[0], 0.0);
    EXPECT_NEAR(mean[1], mean[0], 4.0 * std::sqrt((variance[0] + variance[1]) / seeds));
    EXPECT_LT(variance[1], 0.5 * variance[0]);
}

}  // namespace
}  // namespace surflux
