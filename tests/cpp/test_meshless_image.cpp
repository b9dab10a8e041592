#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "refusal.h"
#include "shapes.h"
#include "surflux/core/random.h"
#include "surflux/render/meshless_image.h"

namespace surflux {
namespace {

constexpr double far_off = std::numeric_limits<double>::infinity();

// Disks on a sphere, and a square of coarse patches that cuts through it: two objects.
Scene ball_and_square(const Vec3& offset = {}) {
    Surfels ball;
    constexpr std::size_t n = 400;
    for (std::size_t i = 0; i < n; ++i) {  // Fibonacci
        const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / n;
        const double phi = static_cast<double>(i) * pi * (3.0 - std::sqrt(5.0)), r = std::sqrt(1.0 - z * z);
        ball.normals.push_back({r * std::cos(phi), r * std::sin(phi), z});
        ball.positions.push_back(offset + Vec3{0, 0, 0.3} + ball.normals.back());
        ball.radii.push_back(1.3 * std::sqrt(4.0 * pi / n));
        ball.areas.push_back(4.0 * pi / n);
    }
    shapes::finish(ball, 0.5, 0.0);
    Surfels square;
    shapes::add_rectangle(square, offset + Vec3{-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, 3, 3);
    shapes::finish(square, 0.5, 0.0);
    Scene scene;
    append(scene, ball);
    append(scene, square);
    return scene;
}

// Levels of 60, 240, ... points by chance on the two objects, coefficients by chance; on finer levels most functions,
// all on one side, have none, as where nothing was gathered.
MeshlessField random_field(std::size_t levels, const Vec3& offset = {}, double largest_radius = far_off) {
    Random random(7);
    MeshlessField field;
    std::size_t count = 60;
    for (std::size_t level = 0; level < levels; ++level, count *= 4) {
        std::vector<Vec3> positions, normals;
        std::vector<std::uint32_t> objects;
        for (std::size_t k = 0; k < count; ++k) {
            if (k % 2) {
                positions.push_back(offset + Vec3{4.0 * random.uniform() - 2.0, 4.0 * random.uniform() - 2.0, 0.0});
                normals.push_back({0, 0, 1});
            } else {
                const double z = 2.0 * random.uniform() - 1.0, phi = 2.0 * pi * random.uniform();
                const double r = std::sqrt(1.0 - z * z);
                normals.push_back({r * std::cos(phi), r * std::sin(phi), z});
                positions.push_back(offset + Vec3{0, 0, 0.3} + normals.back());
            }
            objects.push_back(static_cast<std::uint32_t>(k % 2));
        }
        const SupportOptions options{10, largest_radius};
        field.basis.add_level(positions, normals, objects, options);
        for (const Vec3& p : positions) {
            const bool gathered = level == 0 || p.x - offset.x < -0.5;
            const double scale = level == 0 ? 1.0 : 0.2 * (random.uniform() - 0.5);
            const Rgb value{random.uniform(), random.uniform(), random.uniform()};
            field.gathered.push_back(gathered);
            field.coefficients.push_back(gathered ? scale * (Rgb{0.5, 0.5, 0.5} + value) : Rgb{});
            field.direct.push_back(gathered ? 0.3 * scale * value : Rgb{});
            // Some far from what coarser levels say beside them.
            const Rgb all = (level == 0 ? 1.0 : 2.0 * random.uniform()) * (Rgb{0.5, 0.5, 0.5} + value);
            field.values.push_back(gathered ? MeshlessField::At{all, 0.3 * all} : MeshlessField::At{});
        }
    }
    return field;
}

MeshlessImage drawn(const MeshlessField& field, const Scene& scene, const Camera& camera, gl::Api api,
                    std::size_t width = 160, std::size_t height = 120, const std::vector<VisibleEmitter>& lamps = {},
                    int samples = 1) {
    const DrawnFunctions functions(field);
    return meshless_image(field, functions, nullptr, scene, lamps, camera, width, height, samples, {}, true, api);
}

std::size_t pixels_of(const MeshlessImage& image) {
    return static_cast<std::size_t>(
        std::count_if(image.index.begin(), image.index.end(), [](int i) { return i >= 0; }));
}

// Peak signal to noise in linear light against the field itself at the same places, in dB.
double decibels(const MeshlessImage& image, const MeshlessField& field, const Scene& scene) {
    double peak = 0.0, sum = 0.0;
    std::size_t count = 0;
    for (std::size_t p = 0; p < image.index.size(); ++p) {
        if (image.index[p] < 0) continue;
        const auto surfel = static_cast<std::size_t>(image.index[p]);
        const float* n = &image.normal[3 * p];
        const Vec3 normal =
            normalized({static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])});
        const MeshlessField::At at = field.at(image.position[p], normal, scene.object[surfel]);
        for (int c = 0; c < 3; ++c) {
            const auto k = static_cast<std::size_t>(c);
            const double all = static_cast<double>(image.all[3 * p + k]) - at.all[c];
            const double direct = static_cast<double>(image.direct[3 * p + k]) - at.direct[c];
            peak = std::max(peak, at.all[c]);
            sum += all * all + direct * direct;
            count += 2;
        }
    }
    return 10.0 * std::log10(peak * peak * static_cast<double>(count) / std::max(sum, 1e-300));
}

const Camera front{{1.5, -4, 2.5}, {0, 0, 0.3}, {0, 0, 1}, 50.0};

class MeshlessPicture : public testing::TestWithParam<gl::Api> {};
INSTANTIATE_TEST_SUITE_P(Apis, MeshlessPicture, testing::Values(gl::Api::egl, gl::Api::osmesa),
                         [](const auto& test) { return test.param == gl::Api::egl ? "egl" : "osmesa"; });

TEST_P(MeshlessPicture, IsTheFieldOnDisksAndPatches) {
    const Scene scene = ball_and_square();
    const MeshlessField field = random_field(4);
    const MeshlessImage image = drawn(field, scene, front, GetParam());
    EXPECT_GT(pixels_of(image), 5000u);
    EXPECT_GT(decibels(image, field, scene), 100.0);
}

TEST_P(MeshlessPicture, LeavesOutWhatAddsNothing) {
    const MeshlessField field = random_field(4);
    const DrawnFunctions some(field);
    EXPECT_EQ(some.levels[0].size(), 60u);
    EXPECT_LT(some.levels[3].size(), 2400u);  // of 3840
    EXPECT_GT(some.levels[3].size(), 960u);
    EXPECT_EQ(some.coarsest, (std::vector<std::int32_t>{0, 0}));
    EXPECT_TRUE(some.direct);
}

TEST_P(MeshlessPicture, FromWithinASupport) {
    const Scene scene = ball_and_square();
    const MeshlessField field = random_field(3);
    // 5 cm over the square, whose coarse supports reach farther than that behind the eye, and within the sphere's.
    for (const Camera& camera : {Camera{{-1.2, -1.2, 0.05}, {0.5, 0.2, 0.0}, {0, 0, 1}, 90.0},
                                 Camera{{0, -1.02, 0.3}, {-0.3, 0, 0.3}, {0, 0, 1}, 120.0}}) {
        const MeshlessImage image = drawn(field, scene, camera, GetParam());
        EXPECT_GT(pixels_of(image), 8000u);
        EXPECT_GT(decibels(image, field, scene), 100.0);
    }
}

TEST_P(MeshlessPicture, FromFarAway) {
    const Scene scene = ball_and_square();
    const MeshlessField field = random_field(3);
    const Camera camera{{15000, -40000, 25000}, {0, 0, 0.3}, {0, 0, 1}, 0.005};
    const MeshlessImage image = drawn(field, scene, camera, GetParam());
    EXPECT_GT(pixels_of(image), 5000u);
    EXPECT_GT(decibels(image, field, scene), 100.0);
}

TEST_P(MeshlessPicture, AtSurveyCoordinates) {
    const Vec3 offset{5e6, -5e6, 5e6};
    const Scene scene = ball_and_square(offset);
    const MeshlessField field = random_field(3, offset);
    const Camera camera{front.eye + offset, front.target + offset, front.up, front.fov};
    const MeshlessImage image = drawn(field, scene, camera, GetParam());
    EXPECT_GT(decibels(image, field, scene), 100.0);
    const MeshlessImage here = drawn(random_field(3), ball_and_square(), front, GetParam());
    std::size_t different = 0;
    for (std::size_t p = 0; p < here.index.size(); ++p)
        different += here.index[p] != image.index[p] || std::abs(here.all[3 * p] - image.all[3 * p]) > 1e-3f;
    EXPECT_LE(different, 20u);  // pixels on outlines
}

// The square cuts through the ball: supports of each reach across the other, and say nothing there.
TEST_P(MeshlessPicture, ObjectsKeepTheirLight) {
    const Scene scene = ball_and_square();
    MeshlessField field = random_field(2);
    for (std::uint32_t j = 0; j < field.basis.size(); ++j) {
        const double value = field.basis.level_of(j) > 0 ? 0.0 : field.basis.object(j) == 0 ? 1.0 : 2.0;
        field.coefficients[j] = {value, value, value};
        field.direct[j] = {};
        field.gathered[j] = field.basis.level_of(j) == 0;
        field.values[j] = {field.coefficients[j], {}};
    }
    const MeshlessImage image = drawn(field, scene, front, GetParam());
    std::size_t seen[2] = {0, 0};
    for (std::size_t p = 0; p < image.index.size(); ++p) {
        if (image.index[p] < 0) continue;
        const std::uint32_t object = scene.object[static_cast<std::size_t>(image.index[p])];
        ++seen[object];
        ASSERT_NEAR(image.all[3 * p], object == 0 ? 1.0f : 2.0f, 1e-5f);
        ASSERT_EQ(image.direct[3 * p], 0.0f);
    }
    EXPECT_GT(seen[0], 1000u);
    EXPECT_GT(seen[1], 1000u);
}

// The supports of the finest level end at a wall across the square.
TEST_P(MeshlessPicture, SupportsEndAtTheirCuts) {
    const Scene scene = ball_and_square();
    const MeshlessField whole = random_field(2);
    MeshlessField field = random_field(2);
    std::vector<SupportCut> cuts;
    for (std::uint32_t j = field.basis.first(1); j < field.basis.first(2); ++j) {
        const Vec3& p = field.basis.position(j);
        if (p.x < -1.0 && p.y > 0.2) cuts.push_back({j, {0, 1, 0}, 0.2});
        if (p.x < -1.0) cuts.push_back({j, {-1, 0, 0}, 1.0});
    }
    ASSERT_GT(cuts.size(), 20u);
    field.basis.set_cuts(cuts);
    const MeshlessImage image = drawn(field, scene, front, GetParam());
    EXPECT_GT(decibels(image, field, scene), 100.0);
    EXPECT_LT(decibels(image, whole, scene), 70.0);
}

TEST_P(MeshlessPicture, WhereNothingReachesTheNearestSpeaks) {
    const Scene scene = ball_and_square();
    const MeshlessField field = random_field(2, {}, 0.25);
    const MeshlessImage image = drawn(field, scene, front, GetParam());
    EXPECT_GT(image.fallbacks, 100u);
    EXPECT_LT(image.fallbacks, pixels_of(image) - 1000u);
    EXPECT_GT(decibels(image, field, scene), 95.0);  // of one value's deviation floats leave some 1e-4
    EXPECT_EQ(drawn(random_field(2), scene, front, GetParam()).fallbacks, 0u);
}

// Depths are floats, and of GPUs off by more: what rays begin on is where the patch is.
TEST_P(MeshlessPicture, PlacesOnPatchesAreInTheirPlanes) {
    const Vec3 offset{3e4, -2e4, 1e4};
    Surfels surfels;
    shapes::add_rectangle(surfels, offset + Vec3{-2, -2, -0.5}, {4, 0.3, 0.7}, {-0.2, 4, 0.9}, 6, 6);
    shapes::finish(surfels, 0.5, 0.0);
    const Camera camera{front.eye + offset, front.target + offset, front.up, front.fov};
    const MeshlessImage image = drawn(random_field(1, offset), shapes::scene_of({surfels}), camera, GetParam());
    EXPECT_GT(pixels_of(image), 1000u);
    double off = 0.0;
    for (std::size_t p = 0; p < image.index.size(); ++p) {
        if (image.index[p] < 0) continue;
        const auto i = static_cast<std::size_t>(image.index[p]);
        off = std::max(off, std::abs(dot(surfels.normals[i], image.position[p] - surfels.positions[i])));
    }
    EXPECT_LT(off, 1e-10);
}

// Squares of values are no floats then.
TEST_P(MeshlessPicture, LightMayBeVeryBrightOrDim) {
    const Scene scene = ball_and_square();
    for (const double scale : {1e25, 1e-25}) {
        MeshlessField field = random_field(3);
        for (std::uint32_t j = 0; j < field.basis.size(); ++j) {
            field.coefficients[j] = scale * field.coefficients[j];
            field.direct[j] = scale * field.direct[j];
            field.values[j] = {scale * field.values[j].all, scale * field.values[j].direct};
        }
        EXPECT_GT(decibels(drawn(field, scene, front, GetParam()), field, scene), 95.0) << scale;
    }
}

TEST_P(MeshlessPicture, KnowsWhatItSees) {
    const Scene scene = ball_and_square();
    const MeshlessField field = random_field(1);
    const VisibleEmitter lamp{{-0.2, -1.5, 1.0}, {0.4, 0, 0}, {0, 0, 0.4}, {7, 8, 9}};  // towards -y
    const MeshlessImage image = drawn(field, scene, front, GetParam(), 160, 120, {lamp});
    const CameraFrame frame = frame_of(front);
    std::size_t lamps = 0, nothing = 0;
    for (std::size_t p = 0; p < image.index.size(); ++p) {
        if (image.index[p] == -2) ++lamps;
        if (image.index[p] == -1) {
            ++nothing;
            ASSERT_EQ(image.depth[p], std::numeric_limits<float>::infinity());
        }
        if (image.index[p] < 0) {
            ASSERT_EQ(image.all[3 * p], 0.0f);
            continue;
        }
        const auto surfel = static_cast<std::size_t>(image.index[p]);
        const Vec3 seen = frame.to_camera(image.position[p]);
        ASSERT_NEAR(seen.z, static_cast<double>(image.depth[p]), 1e-5);
        const double x = (2.0 * (static_cast<double>(p % 160) + 0.5) / 160.0 - 1.0) * frame.tan_half * 4.0 / 3.0;
        ASSERT_NEAR(seen.x, x * seen.z, 1e-5);
        // Disks are bent along the surface: over a plane by less than their sagitta.
        const Vec3& normal = scene.surfels.normals[surfel];
        const double away = dot(image.position[p] - scene.surfels.positions[surfel], normal);
        ASSERT_LE(std::abs(away), scene.object[surfel] == 0 ? 0.1 * scene.surfels.radii[surfel] : 1e-4);
        ASSERT_NEAR(static_cast<double>(image.normal[3 * p + 2]), normal.z, scene.object[surfel] == 0 ? 0.2 : 1e-7);
    }
    EXPECT_GT(lamps, 50u);
    EXPECT_GT(nothing, 50u);
}

// In dB, of the means over the subpixels of pixels.
double decibels_of_pixels(const MeshlessImage& image, const MeshlessImage& exact, std::size_t side) {
    double peak = 0.0, sum = 0.0;
    const std::size_t width = image.width / side, height = image.height / side;
    for (std::size_t p = 0; p < width * height; ++p) {
        for (std::size_t c = 0; c < 3; ++c) {
            double off = 0.0, all = 0.0;
            for (std::size_t k = 0; k < side * side; ++k) {
                const std::size_t x = p % width * side + k % side, y = p / width * side + k / side;
                const std::size_t at = 3 * (y * image.width + x) + c;
                all += static_cast<double>(exact.all[at]);
                off += static_cast<double>(image.all[at] - exact.all[at]);
            }
            peak = std::max(peak, all);
            sum += off * off;
        }
    }
    return 10.0 * std::log10(peak * peak * 3.0 * static_cast<double>(width * height) / std::max(sum, 1e-300));
}

TEST_P(MeshlessPicture, SubpixelsOfOneSurfaceHaveOneLight) {
    const Scene scene = ball_and_square();
    const MeshlessField field = random_field(3);
    for (const int samples : {2, 3}) {
        const auto side = static_cast<std::size_t>(samples);
        const std::size_t width = 160 * side, height = 120 * side;
        const MeshlessImage exact = drawn(field, scene, front, GetParam(), width, height);
        const MeshlessImage image = drawn(field, scene, front, GetParam(), width, height, {}, samples);
        EXPECT_EQ(image.index, exact.index);
        EXPECT_EQ(image.depth, exact.depth);
        EXPECT_EQ(image.normal, exact.normal);
        EXPECT_GT(decibels_of_pixels(image, exact, side), 55.0);
        std::size_t same = 0, edges = 0;
        for (std::size_t p = 0; p < 160 * 120; ++p) {
            bool one = true, is_edge = false;
            const std::size_t first = p / 160 * side * width + p % 160 * side;
            for (std::size_t k = 0; k < side * side; ++k) {
                const std::size_t at = first + k / side * width + k % side;
                if (image.index[at] < 0) continue;
                one &= image.index[first] >= 0 && image.all[3 * at] == image.all[3 * first];
                is_edge |= image.index[first] >= 0 && scene.object[static_cast<std::size_t>(image.index[at])] !=
                                                          scene.object[static_cast<std::size_t>(image.index[first])];
            }
            same += one;
            edges += is_edge;
            ASSERT_FALSE(one && is_edge);
        }
        EXPECT_GT(same, 160u * 120u * 9u / 10u);
        EXPECT_GT(edges, 50u);
    }
}

// A line of light that is narrower than a pixel: between the middles of two it was lost.
TEST_P(MeshlessPicture, LightNarrowerThanAPixelIsSeen) {
    const Scene scene = ball_and_square();
    MeshlessField field = random_field(1);
    std::vector<Vec3> positions;
    for (int k = -500; k <= 500; ++k)
        for (int row = -1; row <= 1; ++row) positions.push_back({0.003 * k + 0.001 * row, -1.5 + 0.004 * row, 0.0});
    const std::vector<Vec3> up(positions.size(), {0, 0, 1});
    field.basis.add_level(positions, up, std::vector<std::uint32_t>(positions.size(), 1), {10, far_off});
    for (const Vec3& p : positions) {
        const Rgb value = p.y == -1.5 ? Rgb{9, 9, 9} : Rgb{};
        field.coefficients.push_back(value), field.direct.push_back({}), field.gathered.push_back(true);
        field.values.push_back({Rgb{1, 1, 1} + value, {}});
    }
    for (const std::size_t side : {2u, 4u}) {
        const std::size_t width = 160 * side, height = 120 * side;
        const MeshlessImage exact = drawn(field, scene, front, GetParam(), width, height);
        const MeshlessImage image = drawn(field, scene, front, GetParam(), width, height, {}, static_cast<int>(side));
        EXPECT_GT(decibels_of_pixels(image, exact, side), 65.0) << side;
    }
}

TEST_P(MeshlessPicture, OfNothingIsEmpty) {
    EXPECT_EQ(drawn({}, {}, front, GetParam(), 4, 4, {}, 2).index, std::vector<std::int32_t>(16, -1));
    const MeshlessImage image = drawn({}, {}, front, GetParam(), 5, 4);
    EXPECT_EQ(image.index, std::vector<std::int32_t>(20, -1));
    EXPECT_EQ(image.all, std::vector<float>(60, 0.0f));
}

TEST(MeshlessPictureArguments, AreRefusedByName) {
    const Scene scene = ball_and_square();
    const MeshlessField field = random_field(1);
    const auto with = [&](const Scene& s, const Camera& camera, std::size_t width) {
        return refusal([&] { drawn(field, s, camera, gl::requested_api(), width, 8); });
    };
    EXPECT_NE(with(scene, front, 0).find("size: wanted 1 to 65536 pixels"), std::string::npos);
    EXPECT_NE(with(scene, front, 65536).find("size: this GL device draws at most"), std::string::npos);
    EXPECT_NE(with(scene, {{0, 0, 0}, {0, 0, 0}}, 8).find("target: wanted a point"), std::string::npos);
    const auto subpixels = [&] { drawn(field, scene, front, gl::requested_api(), 9, 8, {}, 2); };
    EXPECT_NE(refusal(subpixels).find("samples: wanted one that sizes and rows are multiples of, got 2"),
              std::string::npos);
    Scene without = scene;
    without.object.clear();
    EXPECT_NE(with(without, front, 8).find("scene: wanted one object for each of 409 surfels, got 0"),
              std::string::npos);
}

}  // namespace
}  // namespace surflux
