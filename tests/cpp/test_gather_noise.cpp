#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "small_strip.h"
#include "surflux/meshless/hemisphere_gather.h"
#include "surflux/meshless/placed_basis.h"
#include "surflux/meshless/row_noise.h"
#include "surflux/meshless/surface_light.h"

namespace surflux {
namespace {

// The small strip sends light, of 1.
struct Gap {
    explicit Gap(std::uint64_t seed)
        : light(scene, tracer, {}, true, 16, {}, 0, {}),
          placed(scene, tracer, light.points(), basis, {0.0, 1, 1.0, 0, {}}, {}),
          gather((placed.add_first({}), scene), tracer, light, basis, placed.means(), {0.314, seed, {}}) {}

    std::vector<Rgb> of_the_strip() const {
        std::vector<Rgb> out;
        for (const std::uint32_t object : scene.object) out.push_back(object == 1 ? Rgb{1.0, 1.0, 1.0} : Rgb{});
        return out;
    }
    std::vector<Place> on_the_floor() const {
        const Surfels& s = scene.surfels;
        std::vector<Place> out;
        for (std::uint32_t i = 0; i < s.size() && scene.object[i] == 0; ++i)
            out.push_back({s.positions[i], s.normals[i], i, Place::point});
        return out;
    }
    double gathered(std::size_t row) const {
        return gather.gather(row, std::vector<Rgb>(basis.size()), of_the_strip()).x;
    }

    Scene scene = small_strip();
    Tracer tracer{scene};
    MultilevelBasis basis;
    SurfaceLight light;
    PlacedBasis placed;
    HemisphereGather gather;
};

double share_of(const HemisphereGather& gather, std::size_t row) {
    double units = 0.0;
    gather.for_senders(row, [&](std::uint32_t, double more) { units += more; });
    return gather[row].share * units + gather[row].escape + gather[row].into_backs;
}

// Rows whose rays are aimed at what these and those around met are the whole hemisphere, too, unbiased, and have less
// noise than as many rays that are not: over 32 seeds.
TEST(GatherNoise, AimedRowsAreUnbiasedAndSeeWhatIsSmall) {
    constexpr int seeds = 32;
    constexpr std::size_t aimed = 5, even = 11;  // rows, both of one place
    double mean[2] = {}, squared[2] = {}, said[2] = {};
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        Gap gap(seed);
        const std::vector<Place> floor = gap.on_the_floor(), places(floor.begin() + 100, floor.begin() + 111);
        const std::vector<int> counts(places.size(), 256);
        const std::vector<Rgb> sent = gap.of_the_strip();
        RowNoise noise(gap.gather);
        gap.gather.add(places, counts, {});
        noise.add(places, std::vector<std::uint32_t>(places.size(), 0), counts, {});
        const std::vector<HemisphereGather::Shot> rows{{aimed, places[aimed], 1024}};
        gap.gather.aim(rows, noise.aims(rows, sent, {}), {});
        EXPECT_LT(gap.gather[aimed].rays, 2u * 1024u);
        gap.gather.add({places[aimed]}, {1024}, {});
        int k = 0;
        for (const std::size_t row : {aimed, even}) {
            EXPECT_NEAR(share_of(gap.gather, row), 1.0, 1e-9);
            const double h = gap.gathered(row), error = gap.gather.standard_error(row, sent);
            mean[k] += h / seeds;
            squared[k] += h * h / seeds;
            said[k++] += error * error / seeds;
        }
    }
    double variance[2];
    for (int k = 0; k < 2; ++k) variance[k] = squared[k] - mean[k] * mean[k];
    EXPECT_GT(mean[1], 0.0);
    EXPECT_NEAR(mean[0], mean[1], 4.0 * std::sqrt((variance[0] + variance[1]) / seeds));
    EXPECT_LT(variance[0], 0.5 * variance[1]);
    // What halves of the rays say of their noise.
    for (int k = 0; k < 2; ++k) {
        EXPECT_GT(said[k], 0.3 * variance[k]);
        EXPECT_LT(said[k], 4.0 * variance[k]);
    }
}

// A row none of whose rays met the strip knows of its noise from those around it; each is shot anew once, with so many
// rays more as it has more noise than it may.
TEST(GatherNoise, RowsAroundAreAsked) {
    Gap gap(0);
    const std::vector<Place> places = gap.on_the_floor();
    const std::vector<int> counts(places.size(), 64);
    RowNoise noise(gap.gather);
    gap.gather.add(places, counts, {});
    noise.add(places, std::vector<std::uint32_t>(places.size(), 0), counts, {});
    noise.find(gap.of_the_strip(), std::vector<double>(places.size(), 1.0));
    std::size_t missed = 0, know = 0, all = 0;
    for (std::size_t k = 0; k < places.size(); ++k) {
        if (noise.standard_error()[k] > 0.0) ++all;
        if (gap.gather.standard_error(k, gap.of_the_strip()) > 0.0) continue;
        ++missed;
        if (noise.standard_error()[k] > 0.0) ++know;
    }
    EXPECT_GT(missed, 100u);
    EXPECT_GT(know, missed / 3);
    EXPECT_TRUE(noise.wanted(std::vector<double>(places.size(), 1.0), 1024).empty());
    EXPECT_TRUE(noise.wanted(std::vector<double>(places.size(), 1e-9), 256).empty());  // fewer than aimed ones have
    const std::vector<HemisphereGather::Shot> rows = noise.wanted(std::vector<double>(places.size(), 1e-9), 1024);
    EXPECT_EQ(rows.size(), all);
    for (const HemisphereGather::Shot& row : rows) EXPECT_EQ(row.count, 1024);
    EXPECT_TRUE(noise.wanted(std::vector<double>(places.size(), 1e-9), 1024).empty());
}

}  // namespace
}  // namespace surflux
