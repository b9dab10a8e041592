#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "surflux/core/error.h"
#include "surflux/gl/objects.h"

namespace surflux::gl {
namespace {

constexpr const char* one_triangle = R"(#version 430
void main() {
    gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1);
}
)";
constexpr const char* one_color = R"(#version 430
uniform vec4 color;
layout(location = 0) out vec4 result;
void main() { result = color; }
)";

// Every test runs on each library: a machine without one of them must not pass.
class Gl : public testing::TestWithParam<Api> {};
INSTANTIATE_TEST_SUITE_P(Apis, Gl, testing::Values(Api::egl, Api::osmesa),
                         [](const auto& test) { return test.param == Api::egl ? "egl" : "osmesa"; });

std::vector<float> read(const Framebuffer& framebuffer, GLsizei side) {
    std::vector<float> texels(4 * static_cast<std::size_t>(side * side));
    framebuffer.read(0, side, side, GL_RGBA, GL_FLOAT, texels.data());
    return texels;
}

TEST_P(Gl, DescribesItself) {
    const Description d = describe(GetParam());
    EXPECT_EQ(d.api.substr(0, 3), GetParam() == Api::egl ? "EGL" : "OSM") << d.api;
    EXPECT_FALSE(d.vendor.empty());
    EXPECT_FALSE(d.renderer.empty());
    EXPECT_GE(std::stod(d.version), 4.3) << d.version;
}

TEST_P(Gl, ClearsAFloatTargetToAnyFloat) {
    run_pass(
        [](const Context& context) {
            const Texture target(context.gl, GL_RGBA32F, 8, 8);
            const Framebuffer framebuffer(context.gl, {&target});
            const float color[4] = {1e20f, -3.25f, 1e-20f, 1234567.0f};
            context.gl.ClearBufferfv(GL_COLOR, 0, color);
            const std::vector<float> texels = read(framebuffer, 8);
            for (std::size_t i = 0; i < texels.size(); ++i) ASSERT_EQ(texels[i], color[i % 4]) << "at " << i;
        },
        GetParam());
}

// 100 x (3, 0.5, 0.25, 1000): every partial sum is a float, so blending in float32 gives it exactly; a target of 8 or
// 16 bits, or one clamped to 1, could not.
TEST_P(Gl, AdditiveBlendingSumsExactly) {
    run_pass(
        [](const Context& context) {
            const Functions& gl = context.gl;
            const Texture target(gl, GL_RGBA32F, 4, 4);
            const Framebuffer framebuffer(gl, {&target});
            const float zero[4] = {0, 0, 0, 0};
            gl.ClearBufferfv(GL_COLOR, 0, zero);
            const Program program(gl, one_triangle, one_color);
            program.use();
            gl.Uniform4f(program.uniform("color"), 3.0f, 0.5f, 0.25f, 1000.0f);
            gl.Viewport(0, 0, 4, 4);
            gl.Enable(GL_BLEND);
            gl.BlendFunc(GL_ONE, GL_ONE);
            for (int i = 0; i < 100; ++i) gl.DrawArrays(GL_TRIANGLES, 0, 3);
            const float expected[4] = {300.0f, 50.0f, 25.0f, 100000.0f};
            const std::vector<float> texels = read(framebuffer, 4);
            for (std::size_t i = 0; i < texels.size(); ++i) ASSERT_EQ(texels[i], expected[i % 4]) << "at " << i;
        },
        GetParam());
}

// Each of 4 groups sums what its 16 invocations share; no group past the last.
TEST_P(Gl, ComputeShadersWriteBuffers) {
    run_pass(
        [](const Context& context) {
            const Functions& gl = context.gl;
            std::vector<float> values(64);
            for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i);
            const Buffer in(gl, values), out(gl, std::vector<float>(5, -1.0f));
            const Program program(gl, R"(#version 430
layout(local_size_x = 16) in;
layout(std430, binding = 0) readonly buffer In { float values[]; };
layout(std430, binding = 1) writeonly buffer Out { float sums[]; };
shared float parts[16];
void main() {
    parts[gl_LocalInvocationIndex] = values[gl_GlobalInvocationID.x];
    barrier();
    if (gl_LocalInvocationIndex > 0u) return;
    float sum = 0.0;
    for (int k = 0; k < 16; ++k) sum += parts[k];
    sums[gl_WorkGroupID.x] = sum;
}
)");
            program.use();
            in.bind(0);
            out.bind(1);
            gl.DispatchCompute(4, 1, 1);
            std::vector<float> sums(5);
            out.read(sums.data(), 5 * sizeof(float));
            EXPECT_EQ(sums, (std::vector<float>{120, 376, 632, 888, -1}));
        },
        GetParam());
}

TEST_P(Gl, TexturesAreWrittenAsTheyAre) {
    run_pass(
        [](const Context& context) {
            const float texels[8] = {1e20f, -3.25f, 1e-20f, 4, 5, 6, 7, 8};
            const Texture texture(context.gl, GL_RGBA32F, 1, 2);
            texture.write(1, 2, GL_RGBA, GL_FLOAT, texels);
            const Framebuffer framebuffer(context.gl, {&texture});
            float found[8] = {};
            framebuffer.read(0, 1, 2, GL_RGBA, GL_FLOAT, found);
            for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(found[i], texels[i]);
        },
        GetParam());
}

// What VTK relies on: a context that the calling thread has current is still current, and intact, after our pass.
TEST_P(Gl, LeavesTheCallersContextCurrent) {
    for (const Api outer : {Api::egl, Api::osmesa}) {
        run_pass(
            [&](const Context& context) {
                const Texture target(context.gl, GL_RGBA32F, 2, 2);
                const Framebuffer framebuffer(context.gl, {&target});
                const float color[4] = {1, 2, 3, 4};
                context.gl.ClearBufferfv(GL_COLOR, 0, color);

                describe(GetParam());

                ASSERT_NE(context.gl.GetString(GL_VERSION), nullptr);
                const std::vector<float> texels = read(framebuffer, 2);
                for (std::size_t i = 0; i < texels.size(); ++i) ASSERT_EQ(texels[i], color[i % 4]);
            },
            outer);
    }
}

TEST_P(Gl, ShaderErrorsCarryTheDriversLog) {
    const auto compile = [](const char* fragment) {
        return [fragment](const Context& context) { Program(context.gl, one_triangle, fragment); };
    };
    try {
        run_pass(compile("#version 430\nvoid main() { nonsense; }\n"), GetParam());
        FAIL() << "a broken shader was taken";
    } catch (const DeviceError& error) {
        EXPECT_NE(std::string(error.what()).find("fragment shader"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("nonsense"), std::string::npos) << error.what();
    }
    try {
        run_pass([](const Context& context) { Program(context.gl, "#version 430\nvoid main() { nonsense; }\n"); },
                 GetParam());
        FAIL() << "a broken compute shader was taken";
    } catch (const DeviceError& error) {
        EXPECT_NE(std::string(error.what()).find("compute shader"), std::string::npos) << error.what();
    }
    try {
        run_pass(
            compile("#version 430\nin vec4 unknown;\nlayout(location = 0) out vec4 c;\nvoid main() { c = unknown; }"),
            GetParam());
        FAIL() << "an input that nothing writes was taken";
    } catch (const DeviceError& error) {
        EXPECT_NE(std::string(error.what()).find("cannot link"), std::string::npos) << error.what();
    }
}

// A second pass has the context of the first, with its programs, and nothing of what that one had set.
TEST_P(Gl, ContextsAreKeptFromPassToPass) {
    std::thread::id first_thread;
    std::size_t linked = 0;
    run_pass(
        [&](const Context& context) {
            first_thread = std::this_thread::get_id();
            Program(context.gl, one_triangle, one_color);
            linked = context.gl.programs.size();
            for (const GLenum capability : {GL_BLEND, GL_DEPTH_TEST, GL_PROGRAM_POINT_SIZE})
                context.gl.Enable(capability);
            context.gl.DepthMask(GL_FALSE);
        },
        GetParam());
    run_pass(
        [&](const Context& context) {
            EXPECT_EQ(std::this_thread::get_id(), first_thread);
            Program(context.gl, one_triangle, one_color);
            EXPECT_EQ(context.gl.programs.size(), linked);
            for (const GLenum state : {GL_BLEND, GL_DEPTH_TEST, GL_PROGRAM_POINT_SIZE}) {
                GLint is_on = 1;
                context.gl.GetIntegerv(state, &is_on);
                EXPECT_EQ(is_on, 0) << state;
            }
            GLint writes_depth = 0;
            context.gl.GetIntegerv(GL_DEPTH_WRITEMASK, &writes_depth);
            EXPECT_EQ(writes_depth, 1);
        },
        GetParam());
}

TEST_P(Gl, PassesAtTheSameTimeHaveContextsOfTheirOwn) {
    run_pass(
        [&](const Context& outer) {
            const Texture texture(outer.gl, GL_RGBA32F, 1, 1);
            run_pass([&](const Context& inner) { EXPECT_NE(&inner, &outer); }, GetParam());
        },
        GetParam());
}

// What it left may be anything.
TEST_P(Gl, AContextThatAPassFailedInIsNotUsedAgain) {
    EXPECT_THROW(run_pass(
                     [&](const Context& context) {
                         Program(context.gl, one_triangle, one_color);
                         throw ArgumentError("mine");
                     },
                     GetParam()),
                 ArgumentError);
    run_pass([&](const Context& context) { EXPECT_TRUE(context.gl.programs.empty()); }, GetParam());
}

TEST_P(Gl, AnErrorLeftByThePassIsThrown) {
    try {
        run_pass([](const Context& context) { context.gl.Enable(0xFFFF); }, GetParam());
        FAIL() << "the error was lost";
    } catch (const DeviceError& error) {
        EXPECT_NE(std::string(error.what()).find("invalid enum"), std::string::npos) << error.what();
    }
}

TEST_P(Gl, AnIncompleteFramebufferIsRefused) {
    EXPECT_THROW(run_pass(
                     [](const Context& context) {
                         const Texture depth(context.gl, GL_DEPTH_COMPONENT32F, 4, 4);
                         const Framebuffer framebuffer(context.gl, {&depth});  // a depth texture as a colour
                     },
                     GetParam()),
                 DeviceError);
}

TEST_P(Gl, WhatThePassThrowsArrives) {
    EXPECT_THROW(run_pass([](const Context&) { throw ArgumentError("mine"); }, GetParam()), ArgumentError);
}

TEST(GlEnvironment, SurfluxGlChoosesTheLibrary) {
    const char* before = std::getenv("SURFLUX_GL");
    const std::string saved = before ? before : "";
    setenv("SURFLUX_GL", "osmesa", 1);
    EXPECT_EQ(describe().api, "OSMesa");
    setenv("SURFLUX_GL", "egl", 1);
    EXPECT_EQ(requested_api(), Api::egl);
    setenv("SURFLUX_GL", "vulkan", 1);
    try {
        describe();
        ADD_FAILURE() << "an unknown word was taken";
    } catch (const ArgumentError& error) {
        EXPECT_STREQ(error.what(), "SURFLUX_GL: wanted egl, osmesa or any, got 'vulkan'");
    }
    unsetenv("SURFLUX_GL");
    EXPECT_EQ(requested_api(), Api::any);
    if (before) setenv("SURFLUX_GL", saved.c_str(), 1);
}

}  // namespace
}  // namespace surflux::gl
