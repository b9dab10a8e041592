#include "surflux/neighbors/depth_steps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "surflux/core/random.h"

namespace surflux {
namespace {

constexpr double step = 0.003;
constexpr int width = 120, height = 90;

// What a depth camera sees of disparities, functions of the picture from -.5 to .5, as they are and in whole steps.
struct Frame {
    std::vector<Vec3> points;
    std::vector<double> disparities;
};
Frame frame_of(const std::function<double(double, double)>& disparity, double noise = 0.0) {
    Random random(0, 0);
    Frame out;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double u = (x + 0.5) / width - 0.5, v = (y + 0.5) / height - 0.5, w = disparity(u, v);
            const double measured = step * std::round(w / step + noise * (2.0 * random.uniform() - 1.0));
            out.points.push_back(Vec3{u, v, 1.0} / measured);
            out.disparities.push_back(w);
        }
    return out;
}

// RMS of what points are off, in steps.
double off(const Frame& frame, const std::vector<Vec3>& points) {
    double sum = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i)
        sum += std::pow((1.0 / points[i].z - frame.disparities[i]) / step, 2.0);
    return std::sqrt(sum / static_cast<double>(points.size()));
}

TEST(DepthSteps, PlanesAreFoundThroughThem) {
    for (const double slope : {0.0, 0.01, 0.03, 0.1, 0.3, 1.0}) {
        const Frame frame = frame_of([&](double u, double v) { return 1.0 + slope * u - 0.4 * slope * v; });
        const SmoothedDepth found = without_depth_steps(frame.points, step);
        EXPECT_LT(off(frame, found.points), slope > 0.0 ? 0.12 : 0.51) << slope;
        for (const char is_off : found.is_off) ASSERT_FALSE(is_off);
    }
}

TEST(DepthSteps, PointsStayOnTheirRays) {
    const Frame frame = frame_of([](double u, double) { return 0.5 + 0.1 * u; }, 1.0);
    const SmoothedDepth found = without_depth_steps(frame.points, step);
    for (std::size_t i = 0; i < frame.points.size(); ++i) {
        const Vec3 &before = frame.points[i], &now = found.points[i];
        ASSERT_LT(length(cross(before, now)), 1e-6 * length_squared(before));
        ASSERT_LT(std::abs(1.0 / now.z - 1.0 / before.z), 6.01 * step * 1.2);
    }
}

TEST(DepthSteps, BordersStaySharp) {
    // A box in front of a wall, six steps apart, and a ramp that rises by four steps a pixel.
    const Frame frame = frame_of([](double u, double v) {
        if (std::abs(u) < 0.2 && std::abs(v) < 0.2) return 1.0 + 0.02 * u + 6.0 * step;
        return v > 0.35 ? 1.0 + 4.0 * step * height * (v - 0.35) : 1.0 + 0.02 * u;
    });
    const SmoothedDepth found = without_depth_steps(frame.points, step);
    EXPECT_LT(off(frame, found.points), 0.25);
}

TEST(DepthSteps, NoiseOfAStepIsAveraged) {
    const Frame frame = frame_of([](double u, double v) { return 0.4 + 0.05 * u + 0.1 * v; }, 1.0);
    EXPECT_GT(off(frame, frame.points), 0.6);
    EXPECT_LT(off(frame, without_depth_steps(frame.points, step).points), 0.2);
}

TEST(DepthSteps, WhatHardlyAnyPixelGoesWithIsOff) {
    Frame frame = frame_of([](double u, double) { return 1.0 + 0.1 * u; });
    const std::size_t alone = 45 * width + 60;
    frame.points[alone] *= 0.9;
    const SmoothedDepth found = without_depth_steps(frame.points, step);
    for (std::size_t i = 0; i < frame.points.size(); ++i) ASSERT_EQ(found.is_off[i] != 0, i == alone) << i;
    EXPECT_NEAR(found.points[alone].z, frame.points[alone].z, 1e-6);
}

TEST(DepthSteps, FewPointsStay) {
    EXPECT_TRUE(without_depth_steps({}, step).points.empty());
    const std::vector<Vec3> points{{0.0, 0.0, 2.0}, {0.1, 0.0, 2.0}, {0.1, 0.1, 2.0}, {0.0, 0.0, 2.0}};
    const SmoothedDepth found = without_depth_steps(points, step);
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(length(found.points[i] - points[i]), 0.0, 1e-6);
}

}  // namespace
}  // namespace surflux
