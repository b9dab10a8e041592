#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "surflux/core/random.h"
#include "surflux/transfer/tilted_light.h"

namespace surflux {
namespace {

constexpr std::size_t channels = TransportOperator::tilted_channels;

Vec3 any_direction(Random& random) {
    return normalized({random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5});
}

// Rows of 0, 1, 2, ... links, whatever is left over of those that are taken together.
TEST(TiltedLight, RowsAddUpValueAndGradientOfAllTheirLinks) {
    constexpr std::uint32_t senders = 300, rows = 40;
    Random random(1);
    TransportOperator of;
    for (std::uint32_t k = 0; k < rows; ++k) {
        TransportOperator::Row row;
        row.begin = static_cast<std::uint32_t>(of.links.size());
        for (std::uint32_t l = 0; l < k; ++l) {
            const auto sender = static_cast<std::uint32_t>(random.uniform() * senders);
            const auto rays = static_cast<std::uint32_t>(1.0 + random.uniform() * 254.9);
            of.links.push_back(sender << TransportOperator::ray_bits | rays);
            of.slopes.push_back({static_cast<std::int8_t>(std::lround(255.0 * random.uniform() - 127.5)),
                                 static_cast<std::int8_t>(std::lround(255.0 * random.uniform() - 127.5))});
        }
        row.end = static_cast<std::uint32_t>(of.links.size());
        row.per_ray = static_cast<float>(0.001 + random.uniform());
        row.u = static_cast<float>(random.uniform() - 0.5), row.v = static_cast<float>(random.uniform() - 0.5);
        of.rows.push_back(row);
        of.normals.push_back(any_direction(random));
    }
    std::vector<float> sent(colors * senders), found;
    for (float& value : sent) value = static_cast<float>(random.uniform());
    of.gather_tilted(sent, found);
    ASSERT_EQ(found.size(), rows * channels);
    for (std::size_t k = 0; k < rows; ++k) {
        const TransportOperator::Row& row = of.rows[k];
        const Frame frame = frame_around(of.normals[k]);
        for (std::size_t c = 0; c < 3; ++c) {
            double value = 0.0;
            Vec3 gradient;
            for (std::uint32_t l = row.begin; l < row.end; ++l) {
                const double light = static_cast<double>(row.per_ray * TransportOperator::rays_of(of.links[l])) *
                                     static_cast<double>(sent[colors * TransportOperator::sender(of.links[l]) + c]);
                constexpr auto scale = static_cast<double>(ShotRows::slope_scale);
                value += light;
                gradient += light * ((of.slopes[l].u / scale - static_cast<double>(row.u)) * frame.u +
                                     (of.slopes[l].v / scale - static_cast<double>(row.v)) * frame.v);
            }
            const float* to = found.data() + k * channels;
            const double near = 1e-5 * (1.0 + 10.0 * value);
            EXPECT_NEAR(static_cast<double>(to[c]), value, near) << k;
            for (std::size_t axis = 0; axis < 3; ++axis)
                EXPECT_NEAR(static_cast<double>(to[3 * (axis + 1) + c]), gradient[static_cast<int>(axis)], near) << k;
        }
    }
}

TEST(TiltedLight, SurfelsHaveWhatTheirNormalsMakeOfRowsAndNeverLessThanNothing) {
    constexpr std::uint32_t functions = 200, surfels = 1100;  // some blocks
    Random random(2);
    std::vector<float> coefficients(channels * functions);
    for (float& value : coefficients) value = static_cast<float>(random.uniform() - 0.4);
    SparseRows rows;
    std::vector<Vec3> normals;
    for (std::uint32_t i = 0; i < surfels; ++i) {
        for (std::uint32_t k = 0; k < i % 7; ++k)
            rows.entries.push_back(
                {static_cast<std::uint32_t>(random.uniform() * functions), static_cast<float>(random.uniform() - 0.2)});
        rows.end_row();
        normals.push_back(any_direction(random));
    }
    std::vector<Rgb> found(surfels, Rgb{7, 7, 7});
    irradiance_at_rows(rows, normals, coefficients.data(), 0, 500, found.data());
    for (int c = 0; c < 3; ++c) EXPECT_EQ(found[500][c], 7.0);
    irradiance_at_rows(rows, normals, coefficients.data(), 500, surfels, found.data());
    int none = 0;
    for (std::uint32_t i = 0; i < surfels; ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            double all = 0.0;
            rows.for_row(i, [&](std::uint32_t column, float weight) {
                const float* from = coefficients.data() + channels * column + c;
                all += static_cast<double>(weight) *
                       (static_cast<double>(from[0]) + normals[i].x * static_cast<double>(from[3]) +
                        normals[i].y * static_cast<double>(from[6]) + normals[i].z * static_cast<double>(from[9]));
            });
            none += i % 7 > 0 && all < -1e-5;
            EXPECT_NEAR(found[i][static_cast<int>(c)], std::max(0.0, all), 1e-5);
        }
    EXPECT_GT(none, 100);
}

}  // namespace
}  // namespace surflux
