#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "splat_pictures.h"

#include "surflux/core/error.h"
#include "surflux/core/sampling.h"
#include "surflux/render/splat.h"

namespace surflux {
namespace {

double largest_difference(const Rgb& a, const Rgb& b) {
    return std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)});
}

void expect_argument_error(const std::function<void()>& action, const std::string& text) {
    try {
        action();
        ADD_FAILURE() << "no error: " << text;
    } catch (const ArgumentError& error) {
        EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
    }
}

class Splat : public testing::TestWithParam<gl::Api> {};
INSTANTIATE_TEST_SUITE_P(Apis, Splat, testing::Values(gl::Api::egl, gl::Api::osmesa),
                         [](const auto& test) { return test.param == gl::Api::egl ? "egl" : "osmesa"; });

// A disk of radius r = 1 around the view axis at depth 4, tilted by 50 degrees about the horizontal axis. Its points
// (r cos t, depth 4 + r sin t sin 50, up r sin t cos 50) project onto a conic; its area by the polygon formula over t.
TEST_P(Splat, OneDiskCoversItsProjectedEllipse) {
    const double tilt = 50.0 * pi / 180.0;
    Surfels s;
    add_disk(s, {0, 0, 0}, {0, -std::cos(tilt), std::sin(tilt)}, 1.0);
    const std::size_t side = 400;
    const Picture image = picture(s, {{2, 3, 4}}, {}, front, side, side, GetParam());
    const double scale = 0.5 * static_cast<double>(side) / std::tan(30.0 * pi / 180.0);
    double area = 0.0, perimeter = 0.0;
    const auto project = [&](double t) {
        const double depth = 4.0 + std::sin(t) * std::sin(tilt);
        return std::array<double, 2>{scale * std::cos(t) / depth, scale * std::sin(t) * std::cos(tilt) / depth};
    };
    for (int i = 0; i < 2000; ++i) {
        const auto a = project(2.0 * pi * i / 2000.0), b = project(2.0 * pi * (i + 1) / 2000.0);
        area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
        perimeter += std::hypot(b[0] - a[0], b[1] - a[1]);
    }
    const auto seen = std::count(image.index.begin(), image.index.end(), 0);
    // The lattice error of a smooth convex outline is far below a tenth of the pixels along it.
    EXPECT_NEAR(static_cast<double>(seen), area, 0.1 * perimeter);
    for (std::size_t p = 0; p < side * side; ++p) {
        if (image.index[p] == -1) {
            ASSERT_EQ(image.depth[p], std::numeric_limits<float>::infinity());
            ASSERT_EQ(image.coverage[p], 0.0f);
            continue;
        }
        // Depth from the plane of the disk: n . (x - c) = 0 on the ray through the pixel's centre.
        const double right = (static_cast<double>(p % side) + 0.5 - 200.0) / scale;
        const double up = -(static_cast<double>(p / side) + 0.5 - 200.0) / scale;
        const Vec3 ray{right, 1.0, up};
        ASSERT_NEAR(image.depth[p], dot(s.normals[0], Vec3{0, 4, 0}) / dot(s.normals[0], ray), 2e-5);
        ASSERT_LE(largest_difference(pixel(image, p % side, p / side), {2, 3, 4}), 1e-5);
        ASSERT_NEAR(image.normal[3 * p + 2], std::sin(tilt), 1e-6);
    }
}

// Weights sum to one: whatever they are, a constant stays, to a rounding of some 2^-24 per term of the sums.
TEST_P(Splat, ConstantRadianceStaysConstant) {
    Surfels s = cube(6);
    for (Vec3& p : s.positions) p += Vec3{-1.2, 0, 0};
    for (Triangle& t : s.triangles) t.a += Vec3{-1.2, 0, 0}, t.b += Vec3{-1.2, 0, 0}, t.c += Vec3{-1.2, 0, 0};
    const Surfels ball = sphere(500, {1.2, 0, 0}, 1.0);
    for (std::size_t i = 0; i < ball.size(); ++i) add_disk(s, ball.positions[i], ball.normals[i], ball.radii[i]);
    const Rgb color{0.37, 12.5, 1e-4};
    const Picture image = picture(s, constant(s, color), {}, front, 200, 150, GetParam());
    std::size_t seen = 0;
    for (std::size_t p = 0; p < image.index.size(); ++p) {
        const Rgb got = pixel(image, p % 200, p / 200);
        if (image.index[p] == -1) {
            ASSERT_EQ(got, Rgb());
            continue;
        }
        ++seen;
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(got[c], color[c], 1e-5 * color[c]) << "pixel " << p;
    }
    EXPECT_GT(seen, 5000u);
}

TEST_P(Splat, FrontDiskHidesTheOneBehind) {
    for (const bool front_first : {true, false}) {
        Surfels s;
        add_disk(s, {0, front_first ? -1.0 : 1.0, 0}, {0, -1, 0}, 1.0);
        add_disk(s, {0, front_first ? 1.0 : -1.0, 0}, {0, -1, 0}, 1.0);
        const std::vector<Rgb> radiance =
            front_first ? std::vector<Rgb>{{1, 0, 0}, {0, 1, 0}} : std::vector<Rgb>{{0, 1, 0}, {1, 0, 0}};
        const Picture image = picture(s, radiance, {}, front, 64, 64, GetParam());
        // The one behind is seen under a smaller angle: nothing of its green comes through.
        for (std::size_t p = 0; p < image.index.size(); ++p) ASSERT_EQ(image.radiance[3 * p + 1], 0.0f);
        EXPECT_EQ(image.radiance[3 * (32 * 64 + 32)], 1.0f);
        EXPECT_EQ(image.depth[32 * 64 + 32], 3.0f);
    }
}

TEST_P(Splat, BackFacesAreNotSeen) {
    Surfels s;
    add_disk(s, {0, 0, 0}, {0, 1, 0}, 1.0);
    add_square(s, {-1, -1, -1}, {0, 0, 2}, {2, 0, 0}, 3);  // faces +y, away from the camera
    const VisibleEmitter lamp{{-1, -2, -1}, {0, 0, 2}, {2, 0, 0}, {9, 9, 9}};
    const Picture image = picture(s, constant(s, {1, 1, 1}), {lamp}, front, 64, 64, GetParam());
    for (std::size_t p = 0; p < image.index.size(); ++p) {
        ASSERT_EQ(image.index[p], -1);
        ASSERT_EQ(pixel(image, p % 64, p / 64), Rgb());
    }
}

// Three faces of a cube in one colour each: every pixel has exactly the colour of the face it sees, up to the edges,
// and the outline is that of the projected cube.
TEST_P(Splat, NothingBleedsAcrossTheEdgesOfACube) {
    const Surfels s = cube(4);
    std::vector<Rgb> radiance(s.size());
    for (std::size_t i = 0; i < s.size(); ++i) {
        const std::size_t face = i / 16;
        radiance[i] = {face / 2 == 0 ? 1.0 : 0.0, face / 2 == 1 ? 1.0 : 0.0, face / 2 == 2 ? 1.0 : 0.0};
    }
    const Camera camera{{4, -5, 3}, {0, 0, 0}, {0, 0, 1}, 40.0};
    const std::size_t side = 200;
    const Picture image = picture(s, radiance, {}, camera, side, side, GetParam());
    const CameraFrame frame = frame_of(camera);
    std::size_t seen = 0, wrong = 0;
    for (std::size_t p = 0; p < side * side; ++p) {
        const double x = (2.0 * (static_cast<double>(p % side) + 0.5) / side - 1.0) * frame.tan_half;
        const double y = (2.0 * (static_cast<double>(p / side) + 0.5) / side - 1.0) * frame.tan_half;
        const Vec3 ray = frame.forward + x * frame.right + y * frame.down;
        // Slab test against [-1, 1]^3: the axis of the face where the ray enters, or none.
        double enter = 0.0, leave = 1e9;
        int axis_seen = -1;
        for (int axis = 0; axis < 3; ++axis) {
            double a = (-1.0 - camera.eye[axis]) / ray[axis], b = (1.0 - camera.eye[axis]) / ray[axis];
            if (a > b) std::swap(a, b);
            if (a > enter) enter = a, axis_seen = axis;
            leave = std::min(leave, b);
        }
        if (enter > leave) axis_seen = -1;
        Rgb expected;
        if (axis_seen >= 0) expected[axis_seen] = 1.0, ++seen;
        if (largest_difference(pixel(image, p % side, p / side), expected) > 1e-5) ++wrong;
    }
    EXPECT_GT(seen, 8000u);
    // Only pixel centres that lie on an edge to the rasterizer's 1/256 pixel may fall on its other side.
    EXPECT_LE(wrong, 5u);
}

TEST_P(Splat, FarFromTheOriginThePictureIsTheSame) {
    const Vec3 offset{5e6, -3e6, 4e6};
    Surfels s = sphere(400, {0.5, 0, 0}, 1.0);
    add_square(s, {-2, 1.5, -2}, {4, 0, 0}, {0, 0, 4}, 8);
    VisibleEmitter lamp{{-1, -1, 1.2}, {0, 0.5, 0}, {0.5, 0, 0}, {5, 5, 5}};
    std::vector<Rgb> radiance;
    for (std::size_t i = 0; i < s.size(); ++i)
        radiance.push_back({0.5 + 0.5 * s.positions[i].x, s.normals[i].z + 1.0, 1.0});
    const Picture here = picture(s, radiance, {lamp}, front, 160, 120, GetParam());
    for (Vec3& p : s.positions) p += offset;
    for (Triangle& t : s.triangles) t.a += offset, t.b += offset, t.c += offset;
    lamp.corner += offset;
    Camera camera = front;
    camera.eye += offset;
    camera.target += offset;
    const Picture there = picture(s, radiance, {lamp}, camera, 160, 120, GetParam());
    // Doubles at 5e6 step by 1e-9: no more than a stray pixel on an outline can differ.
    std::size_t different = 0;
    for (std::size_t p = 0; p < here.index.size(); ++p) {
        different += largest_difference(pixel(here, p % 160, p / 160), pixel(there, p % 160, p / 160)) > 1e-4;
    }
    EXPECT_LE(different, 2u);
}

// Linear radiance over a plane of patches: a blend of a regular lattice with this kernel reproduces it closely away
// from the border, so the picture shows a ramp, not cells. Cells of constant colour would be off by half the step,
// 0.05.
TEST_P(Splat, ALinearRampIsSmooth) {
    Surfels s;
    add_square(s, {-2, 0, -2}, {4, 0, 0}, {0, 0, 4}, 20);
    std::vector<Rgb> radiance;
    for (const Vec3& p : s.positions) radiance.push_back({1.0 + 0.5 * p.x, 1.0 + 0.5 * p.z, 1.0});
    const Picture image = picture(s, radiance, {}, front, 120, 120, GetParam());
    const double scale = 60.0 / std::tan(30.0 * pi / 180.0);
    for (std::size_t y = 20; y < 100; ++y) {
        for (std::size_t x = 20; x < 100; ++x) {
            const double right = 4.0 * (static_cast<double>(x) + 0.5 - 60.0) / scale;
            const double up = -4.0 * (static_cast<double>(y) + 0.5 - 60.0) / scale;
            ASSERT_LE(largest_difference(pixel(image, x, y), {1.0 + 0.5 * right, 1.0 + 0.5 * up, 1.0}), 0.005);
        }
    }
}

// However far from its centre the triangles of a surfel lie, they have its colour.
TEST_P(Splat, ATriangleFarFromItsSurfelHasItsColour) {
    Surfels s;
    add_disk(s, {0, 0, 0}, {0, -1, 0}, 0.01);
    s.triangles.push_back({{0.9, 0, -0.05}, {1.0, 0, -0.05}, {0.9, 0, 0.05}, 0});
    const Picture image = picture(s, {{3, 2, 1}}, {}, front, 200, 200, GetParam());
    const auto seen = std::count(image.index.begin(), image.index.end(), 0);
    EXPECT_GT(seen, 5);
    for (std::size_t p = 0; p < image.index.size(); ++p) {
        if (image.index[p] == 0) {
            ASSERT_LT(largest_difference(pixel(image, p % 200, p / 200), {3, 2, 1}), 1e-5);
        }
    }
}

TEST_P(Splat, EmitterInThePlaneOfACeilingIsInFrontOfIt) {
    Surfels s;
    add_square(s, {-3, 0, -3}, {6, 0, 0}, {0, 0, 6}, 10);
    const VisibleEmitter lamp{{-0.5, 0, -0.5}, {1, 0, 0}, {0, 0, 1}, {7, 8, 9}};
    const Picture image = picture(s, constant(s, {1, 1, 1}), {lamp}, front, 120, 120, GetParam());
    const double scale = 60.0 / std::tan(30.0 * pi / 180.0) / 4.0;
    for (std::size_t p = 0; p < image.index.size(); ++p) {
        const double right = (static_cast<double>(p % 120) + 0.5 - 60.0) / scale;
        const double up = (static_cast<double>(p / 120) + 0.5 - 60.0) / scale;
        const bool lit = std::abs(right) < 0.5 && std::abs(up) < 0.5;
        ASSERT_EQ(image.index[p] == -2, lit);
        ASSERT_LE(largest_difference(pixel(image, p % 120, p / 120), lit ? Rgb{7, 8, 9} : Rgb{1, 1, 1}), 1e-5);
    }
    EXPECT_EQ(image.normal[3 * (60 * 120 + 60) + 1], -1.0f);
}

// A lamp close under a ceiling that faces the same way: near enough to blend, but another object.
TEST_P(Splat, ColoursStayWithinTheirObject) {
    Surfels s;
    add_disk(s, {0, 1, 0}, {0, -1, 0}, 4.0);
    add_disk(s, {0, 0.9, 0}, {0, -1, 0}, 0.5);
    SplatOptions options;
    const auto brightest_beside = [&](const SplatOptions& o) {
        const Picture image = picture(s, {{1, 1, 1}, {9, 9, 9}}, {}, front, 120, 120, GetParam(), o);
        float brightest = 0.0f;
        for (std::size_t p = 0; p < image.index.size(); ++p)
            if (image.index[p] == 0) brightest = std::max(brightest, image.radiance[3 * p]);
        return brightest;
    };
    EXPECT_GT(brightest_beside(options), 1.5f);  // as one object they blend
    options.objects = {0, 1};
    EXPECT_NEAR(brightest_beside(options), 1.0f, 1e-5f);
}

// Known areas allow smaller disks: S = pi/4 gives 1.4 sqrt(S) = 1.0635 instead of R = 2.
TEST_P(Splat, KnownAreasBoundTheDisks) {
    Surfels s;
    add_disk(s, {0, 0, 0}, {0, -1, 0}, 2.0);
    s.areas = {pi / 4.0};
    const Picture image = picture(s, {{1, 1, 1}}, {}, front, 400, 400, GetParam());
    const double radius = 1.4 * std::sqrt(pi / 4.0) * 200.0 / std::tan(30.0 * pi / 180.0) / 4.0;
    const auto seen = static_cast<double>(std::count(image.index.begin(), image.index.end(), 0));
    EXPECT_NEAR(seen, pi * radius * radius, 0.1 * 2.0 * pi * radius);
}

TEST_P(Splat, SubpixelsAverage) {
    Surfels s;
    add_square(s, {-1, 0, -1}, {2, 0, 0}, {0, 0, 2}, 2);
    SplatOptions one, four;
    one.samples = 1;
    four.samples = 4;
    const Picture fine = picture(s, constant(s, {1, 1, 1}), {}, front, 400, 400, GetParam(), one);
    const Picture coarse = picture(s, constant(s, {1, 1, 1}), {}, front, 100, 100, GetParam(), four);
    for (std::size_t y = 0; y < 100; ++y) {
        for (std::size_t x = 0; x < 100; ++x) {
            double mean = 0.0;
            for (std::size_t k = 0; k < 16; ++k) mean += pixel(fine, 4 * x + k % 4, 4 * y + k / 4).x / 16.0;
            ASSERT_NEAR(pixel(coarse, x, y).x, mean, 1e-6);
            ASSERT_NEAR(coarse.coverage[y * 100 + x], mean, 1e-5);
        }
    }
}

// Inside of a closed room nothing is missing, and surfels beside and behind the eye do no harm.
TEST_P(Splat, InsideOfARoomEveryPixelIsCovered) {
    Surfels s = cube(10);
    for (Vec3& n : s.normals) n = -n;
    for (Triangle& t : s.triangles) std::swap(t.b, t.c);
    const Camera camera{{-0.9, -0.9, -0.2}, {0.5, 0.5, 0}, {0, 0, 1}, 100.0};
    const Picture image = picture(s, constant(s, {1, 2, 3}), {}, camera, 160, 120, GetParam());
    for (std::size_t p = 0; p < image.index.size(); ++p) {
        ASSERT_GE(image.index[p], 0);
        ASSERT_LE(largest_difference(pixel(image, p % 160, p / 160), {1, 2, 3}), 3e-5);
    }
}

TEST(SplatArguments, AreRefusedByName) {
    Surfels s;
    add_disk(s, {0, 0, 0}, {0, -1, 0}, 1.0);
    const std::vector<Rgb> one{{1, 1, 1}};
    const double nan = std::nan("");
    const auto with = [&](const Camera& camera, std::size_t width, const SplatOptions& options,
                          const std::vector<Rgb>& radiance, const std::vector<VisibleEmitter>& lamps) {
        return [=] { splat_image(s, {{radiance}}, lamps, camera, width, 8, options); };
    };
    expect_argument_error(with({{0, 0, 0}, {0, 0, 0}}, 8, {}, one, {}), "target: wanted a point other than the eye");
    expect_argument_error(with({{0, 0, 0}, {0, 0, 1}}, 8, {}, one, {}), "up: wanted a direction not parallel");
    expect_argument_error(with({{0, 0, 0}, {0, 1, 0}, {0, 0, 0}}, 8, {}, one, {}), "up: wanted a direction, got zero");
    expect_argument_error(with({{nan, 0, 0}, {0, 0, 1}}, 8, {}, one, {}), "eye: wanted finite");
    expect_argument_error(with({{0, 0, 0}, {0, nan, 1}}, 8, {}, one, {}), "target: wanted finite");
    expect_argument_error(with({{0, 0, 0}, {0, 1, 0}, {0, nan, 1}}, 8, {}, one, {}), "up: wanted finite");
    for (const double fov : {0.0, 180.0, nan}) {
        expect_argument_error(with({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}, fov}, 8, {}, one, {}), "fov: wanted degrees");
    }
    expect_argument_error(with(front, 0, {}, one, {}), "size: wanted 1 to 65536 pixels");
    expect_argument_error(with(front, 60000, {1.5, 16}, one, {}), "size: this GL device draws at most");
    SplatOptions rows;
    rows.rows = {8, 2};
    expect_argument_error(with(front, 8, rows, one, {}), "rows: wanted some of 8, got 2 from 8 on");
    expect_argument_error(with(front, 8, {1.5, 1, true, {0, 0}}, one, {}), "objects: wanted one for each of 1");
    expect_argument_error(with(front, 8, {0.9}, one, {}), "footprint: wanted 1 to 10");
    const KernelWalls of_none(Surfels{}, 1.5);
    SplatOptions walled;
    walled.walls = &of_none;
    expect_argument_error(with(front, 8, walled, one, {}), "walls: wanted those of 1 surfels");
    expect_argument_error(with(front, 8, {1.5, 0}, one, {}), "samples: wanted 1 to 16");
    expect_argument_error(with(front, 8, {}, {}, {}), "values: wanted one RGB value for each of 1 surfels, got 0");
    expect_argument_error(with(front, 8, {}, {{nan, 0, 0}}, {}), "values: wanted finite");
    expect_argument_error(with(front, 8, {}, one, {{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 1}}}),
                          "emitters: the edges");
    expect_argument_error(with(front, 8, {}, one, {{{nan, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1}}}),
                          "emitters: number 0");
}

TEST(SplatArguments, AnEmptySceneIsBlackAndCoversNothing) {
    const Picture image = picture({}, {}, {}, front, 5, 4, gl::Api::any);
    EXPECT_EQ(image.radiance, std::vector<float>(60, 0.0f));
    EXPECT_EQ(image.coverage, std::vector<float>(20, 0.0f));
}

}  // namespace
}  // namespace surflux
