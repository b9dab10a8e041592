#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "shapes.h"
#include "surflux/area/atlas.h"
#include "surflux/area/effective_area.h"
#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/random.h"
#include "surflux/gl/objects.h"

namespace surflux {
namespace {

// Every test runs on each library, as SURFLUX_GL names them.
class AreaGl : public testing::TestWithParam<const char*> {
protected:
    void SetUp() override {
        if (const char* before = std::getenv("SURFLUX_GL")) saved_ = before;
        setenv("SURFLUX_GL", GetParam(), 1);
    }
    void TearDown() override {
        if (saved_.empty())
            unsetenv("SURFLUX_GL");
        else
            setenv("SURFLUX_GL", saved_.c_str(), 1);
    }

private:
    std::string saved_;
};
INSTANTIATE_TEST_SUITE_P(Apis, AreaGl, testing::Values("egl", "osmesa"),
                         [](const auto& test) { return std::string(test.param); });

AreaOptions with(AreaOptions options, AreaBackend backend) {
    options.backend = backend;
    return options;
}

std::vector<double> by_gl(const Surfels& s, const AreaOptions& options, const Progress& progress = {}) {
    return effective_areas(s, with(options, AreaBackend::gl), progress);
}

// How many areas of the two backends differ by more than `tolerance`, relatively.
std::size_t disagreements(const Surfels& s, const AreaOptions& options, double tolerance) {
    const std::vector<double> cpu = effective_areas(s, with(options, AreaBackend::cpu)), gl = by_gl(s, options);
    EXPECT_EQ(cpu.size(), gl.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < cpu.size(); ++i)
        if (!(std::abs(gl[i] - cpu[i]) <= tolerance * cpu[i])) ++count;
    return count;
}

Surfels with_normals(std::vector<Vec3> positions, std::vector<Vec3> normals, double wider = 1.0) {
    Surfels s;
    s.positions = std::move(positions);
    s.normals = std::move(normals);
    s.radii = estimate_radii(s.positions);
    for (double& r : s.radii) r *= wider;
    shapes::finish(s, 0.5, 0.0);
    return s;
}

Surfels random_sphere(std::size_t n) {
    Random random(7);
    std::vector<Vec3> p;
    while (p.size() < n) {
        const Vec3 v{2 * random.uniform() - 1, 2 * random.uniform() - 1, 2 * random.uniform() - 1};
        if (length_squared(v) < 1.0 && length_squared(v) > 0.01) p.push_back(normalized(v));
    }
    return with_normals(p, p);
}

// Random points on the six faces of a cube: every way that creases end a disk or share it.
Surfels random_cube(std::size_t n) {
    Random random(8);
    std::vector<Vec3> p, normals;
    for (std::size_t k = 0; k < n; ++k) {
        const int axis = static_cast<int>(k % 3), side = static_cast<int>(k / 3 % 2) * 2 - 1;
        Vec3 v{2 * random.uniform() - 1, 2 * random.uniform() - 1, 2 * random.uniform() - 1}, normal;
        v[axis] = normal[axis] = side;
        p.push_back(v);
        normals.push_back(normal);
    }
    return with_normals(p, normals);
}

Surfels random_sheet(std::size_t n) {
    Random random(9);
    std::vector<Vec3> p;
    for (std::size_t k = 0; k < n; ++k) p.push_back({random.uniform(), random.uniform(), 0.0});
    return with_normals(p, std::vector<Vec3>(n, Vec3{0, 0, 1}));
}

// Pixel centres on the rim of a disk, within rounding, may fall on either side of it: the paper's weight is cut there.
TEST_P(AreaGl, AgreesWithTheProcessorOnEveryShape) {
    std::size_t all = 0, paper = 0;
    for (const Surfels& s :
         {shapes::sphere(600, 1.0, 1.0, 0.5, 0.0), random_sphere(600), random_cube(600), random_sheet(400)}) {
        for (double kappa : {1.0, 3.0, 8.0}) {
            EXPECT_EQ(disagreements(s, {AreaMethod::curved, kappa, 32, 0.8}, 1e-5), 0u) << kappa;
            paper += disagreements(s, {AreaMethod::paper, kappa, 32, 0.8}, 1e-4);
            all += s.size();
        }
    }
    EXPECT_LE(static_cast<double>(paper), 1e-3 * static_cast<double>(all));
}

TEST_P(AreaGl, AgreesAtAnyResolution) {
    // A thousandth wider than a distance between points: no rim passes through the centre of another disk.
    const Surfels s = with_normals(random_sphere(300).positions, random_sphere(300).normals, 1.001);
    for (int resolution : {4, 5, 7, 33, 100, 101}) {
        EXPECT_EQ(disagreements(s, {AreaMethod::curved, 3.0, resolution, 0.8}, 1e-5), 0u) << resolution;
        EXPECT_LE(disagreements(s, {AreaMethod::paper, 3.0, resolution, 0.8}, 1e-4), 1u) << resolution;
    }
}

// Few tiles fit an atlas at this resolution.
TEST_P(AreaGl, ManyAtlasesMakeOneResult) {
    const Surfels s = random_sphere(140);
    for (const AreaMethod method : {AreaMethod::paper, AreaMethod::curved}) {
        const AreaOptions options{method, 3.0, 256, 0.8};
        EXPECT_EQ(disagreements(s, options, 1e-4), 0u);
        std::vector<std::size_t> reports;
        by_gl(s, options, [&](std::size_t done, std::size_t total) {
            EXPECT_EQ(total, s.size());
            reports.push_back(done);
            return true;
        });
        EXPECT_GE(reports.size(), 3u);
        EXPECT_TRUE(std::is_sorted(reports.begin(), reports.end()));
        EXPECT_EQ(reports.back(), s.size());
    }
}

TEST_P(AreaGl, OfOneDiskOfNoneAndOfPatches) {
    const Surfels alone = shapes::disk({1, 2, 3}, normalized({1, 1, 1}), 0.3);
    for (const AreaMethod method : {AreaMethod::paper, AreaMethod::curved}) {
        const AreaOptions options{method, 3.0, 512, 0.8};
        EXPECT_NEAR(by_gl(alone, options)[0], pi * 0.09, 2e-4 * pi * 0.09);
        EXPECT_TRUE(by_gl(Surfels(), options).empty());
        const Surfels patches = shapes::cube_inside(3, 0.5, 0.0);
        EXPECT_EQ(by_gl(patches, options), effective_areas(patches, with(options, AreaBackend::cpu)));
    }
}

// Weights range over what a float holds: coincident points, disks a thousand times as large, the steepest weights.
TEST_P(AreaGl, StaysFiniteWhereWeightsAreExtreme) {
    Surfels s = random_sheet(300);
    for (std::size_t k = 0; k < s.size(); k += 10) s.positions[k] = s.positions[k + 1];
    for (std::size_t k = 0; k < s.size(); k += 7) s.radii[k] *= 1e-3;
    for (std::size_t k = 3; k < s.size(); k += 50) s.radii[k] *= 10.0;
    for (double kappa : {0.1, 3.0, 8.0})
        EXPECT_EQ(disagreements(s, {AreaMethod::curved, kappa, 32, 0.8}, 1e-4), 0u) << kappa;
    for (double kappa : {0.1, 80.0})
        EXPECT_LE(disagreements(s, {AreaMethod::paper, kappa, 32, 0.8}, 1e-3), 2u) << kappa;
}

TEST_P(AreaGl, IsTheSameEveryTimeAndForAnyNumberOfThreads) {
    const Surfels s = random_sphere(500);
    for (const AreaMethod method : {AreaMethod::paper, AreaMethod::curved}) {
        const std::vector<double> all = by_gl(s, {method, 3.0, 32, 0.8});
        const ThreadLimit one(1);
        EXPECT_EQ(by_gl(s, {method, 3.0, 32, 0.8}), all);
    }
}

TEST_P(AreaGl, StopsWhenAskedTo) {
    const Surfels s = random_sphere(70);
    const AreaOptions options{AreaMethod::paper, 3.0, 256, 0.8};
    for (const std::size_t stop_at : {0u, 32u, 70u}) {
        EXPECT_THROW(by_gl(s, options, [&](std::size_t done, std::size_t) { return done < stop_at; }), Cancelled);
    }
}

TEST_P(AreaGl, LeavesTheCallersContextCurrent) {
    gl::run_pass([](const gl::Context& context) {
        const gl::Texture target(context.gl, GL_RGBA32F, 2, 2);
        const gl::Framebuffer framebuffer(context.gl, {&target});
        const float color[4] = {1, 2, 3, 4};
        context.gl.ClearBufferfv(GL_COLOR, 0, color);
        EXPECT_GT(by_gl(random_sphere(50), {})[0], 0.0);
        float texels[16] = {};
        framebuffer.read(0, 2, 2, GL_RGBA, GL_FLOAT, texels);
        for (std::size_t i = 0; i < 16; ++i) ASSERT_EQ(texels[i], color[i % 4]);
    });
}

TEST(AreaBackend, IsTheProcessorForSmallCloudsAndOnSoftwareRenderers) {
    const Surfels s = random_sphere(200);
    EXPECT_EQ(effective_areas(s, {}), effective_areas(s, with({}, AreaBackend::cpu)));
    const AreaOptions paper{AreaMethod::paper, 3.0, 32, 0.8}, coarse, fine{AreaMethod::curved, 3.0, 64, 0.8};
    EXPECT_FALSE(atlas_may_pay(140'000, paper, 1));
    EXPECT_TRUE(atlas_may_pay(150'000, paper, 1));
    EXPECT_FALSE(atlas_may_pay(150'000, paper, 2));
    EXPECT_FALSE(atlas_may_pay(100'000'000, coarse, 1));
    EXPECT_TRUE(atlas_may_pay(135'000, fine, 1));
    for (const char* name :
         {"llvmpipe (LLVM 15.0.6, 256 bits)", "softpipe", "Software Rasterizer", "Mesa OffScreen swrast",
          "ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero)), SwiftShader driver)",
          "zink (llvmpipe (LLVM 15.0.6, 256 bits))", "SWR (LLVM 12.0.0, 256 bits) OpenSWR"})
        EXPECT_TRUE(gl::is_software({"EGL", "", name, ""})) << name;
    for (const char* name : {"NVIDIA H100/PCIe/SSE2", "AMD Radeon RX 7900 XTX (radeonsi, navi31, LLVM 15.0.7)",
                             "Mesa Intel(R) UHD Graphics 620 (KBL GT2)", "D3D12 (NVIDIA GeForce RTX 3080)"})
        EXPECT_FALSE(gl::is_software({"EGL", "", name, ""})) << name;
}

}  // namespace
}  // namespace surflux
