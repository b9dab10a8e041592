#include "surflux/render/flat_field.h"

#include <cmath>

#include <gtest/gtest.h>

#include "shapes.h"

namespace surflux {
namespace {

const Camera camera{{0.5, -2, 1.5}, {0.5, 0.5, 0}, {0, 0, 1}, 50.0};

struct Flat {
    CompiledScene compiled;
    PatchCorners corners;
    PixelPlaces places;
    FlatField field;

    explicit Flat(const std::vector<Surfels>& objects, std::vector<double> areas = {})
        : compiled(shapes::scene_of(objects)) {
        const Scene& scene = compiled.scene();
        if (areas.empty()) areas = scene.surfels.areas;
        corners = patch_corners(scene, compiled.tracer(), areas);
        places = pixel_places(compiled, camera, 120, 90);
        field = flat_field(scene, corners, places, camera);
    }

    std::vector<FlatField::Value> draw(const std::vector<Rgb>& values) const {
        std::vector<FlatField::Value> at_nodes, out;
        field.at_nodes(values, at_nodes);
        for (std::size_t p = 0; p < places.size(); ++p) out.push_back(field.at_pixel(p, at_nodes));
        return out;
    }
    const Surfels& surfels() const { return compiled.scene().surfels; }
};

Surfels floor(int cells) {
    Surfels s;
    shapes::add_rectangle(s, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, cells, cells);
    shapes::finish(s, 0.5, 0.0);
    return s;
}

// Each row makes 1: what is the same everywhere is drawn so, on patches and on disks.
TEST(FlatField, ConstantsStayConstant) {
    const Flat flat({floor(10), shapes::sphere(600, 0.3, 1.0, 0.5, 0.0, {0.5, 0.5, 0.3})});
    const std::vector<FlatField::Value> drawn = flat.draw(std::vector<Rgb>(flat.surfels().size(), {2, 3, 5}));
    std::size_t patches = 0, disks = 0;
    for (std::size_t p = 0; p < drawn.size(); ++p) {
        const bool seen = flat.places.is_seen(p);
        if (seen) (flat.places.triangle[p] == PixelPlaces::none ? disks : patches) += 1;
        const float wanted[3] = {2, 3, 5};
        for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(drawn[p][c], seen ? wanted[c] : 0.0f, 1e-5);
    }
    EXPECT_GT(patches, 400u);
    EXPECT_GT(disks, 300u);
}

// A corner within the floor is as far from the centres of its four patches: a linear field has its own value there, and
// keeps it between corners.
TEST(FlatField, LinearFieldsStayLinearInsideOfAFloor) {
    const Flat flat({floor(10)});
    std::vector<Rgb> values;
    for (const Vec3& p : flat.surfels().positions) values.push_back({p.x, p.y, 1.0 + 2.0 * p.x - p.y});
    const std::vector<FlatField::Value> drawn = flat.draw(values);
    std::size_t inside = 0;
    for (std::size_t p = 0; p < drawn.size(); ++p) {
        if (!flat.places.is_seen(p)) continue;
        const Vec3 at = flat.places.place(p);
        if (std::min({at.x, at.y, 1.0 - at.x, 1.0 - at.y}) < 0.1) continue;
        ++inside;
        ASSERT_NEAR(drawn[p][0], at.x, 1e-5);
        ASSERT_NEAR(drawn[p][1], at.y, 1e-5);
        ASSERT_NEAR(drawn[p][2], 1.0 + 2.0 * at.x - at.y, 3e-5);
    }
    EXPECT_GT(inside, 300u);
}

// What meets at an edge, stands under a wall, or is of another object, is not averaged.
TEST(FlatField, NothingBleedsOverEdgesNorBeneathWallsNorIntoOtherObjects) {
    Surfels edge = floor(6);  // and a wall up from its far side
    shapes::add_rectangle(edge, {0, 1, 0}, {1, 0, 0}, {0, 0, 0.5}, 6, 3);
    shapes::finish(edge, 0.5, 0.0);
    Surfels thin;  // stands on the floor, along a line of corners
    shapes::add_rectangle(thin, {0.5, 0, 0}, {0, 1, 0}, {0, 0, 0.4}, 6, 2);
    shapes::finish(thin, 0.5, 0.0);
    Surfels other;  // goes on beside the floor
    shapes::add_rectangle(other, {1, 0, 0}, {0.5, 0, 0}, {0, 1, 0}, 3, 6);
    shapes::finish(other, 0.5, 0.0);
    const Flat flat({edge, thin, other});
    std::vector<Rgb> values;  // left, right, and on which object
    for (std::size_t i = 0; i < flat.surfels().size(); ++i) {
        const Vec3& p = flat.surfels().positions[i];
        const bool up = std::abs(flat.surfels().normals[i].z) < 0.5;
        values.push_back(
            {p.x < 0.5 && !up ? 1.0 : 0.0, up ? 1.0 : 0.0, static_cast<double>(flat.compiled.scene().object[i])});
    }
    const std::vector<FlatField::Value> drawn = flat.draw(values);
    for (std::size_t p = 0; p < drawn.size(); ++p) {
        if (!flat.places.is_seen(p)) continue;
        const std::uint32_t surfel = flat.places.surfel[p];
        for (std::size_t c = 0; c < 3; ++c)
            ASSERT_NEAR(drawn[p][c], values[surfel][static_cast<int>(c)], 1e-5) << surfel << " " << c;
    }
}

// A floor goes on below a plinth, where it has no area that light comes to: what is said of it there does not show.
TEST(PatchCorners, WhatIsBuriedHasNoSay) {
    const Surfels ground = floor(4);
    std::vector<double> areas = ground.areas;
    areas[5] = 0.0;
    const Flat flat({ground}, areas);
    std::vector<Rgb> values(16, {1, 1, 1});
    values[5] = {};
    const std::vector<FlatField::Value> drawn = flat.draw(values);
    for (std::size_t p = 0; p < drawn.size(); ++p) ASSERT_NEAR(drawn[p][0], flat.places.is_seen(p), 1e-5);
}

// The facets of a column are one surface, its ends are not of it.
TEST(PatchCorners, FacetsOfAColumnAreOneSurface) {
    Surfels column;
    constexpr int facets = 24;
    const auto at = [](int k) { return Vec3{std::cos(2 * pi * k / facets), std::sin(2 * pi * k / facets), 0}; };
    for (int k = 0; k < facets; ++k) shapes::add_rectangle(column, at(k), at(k + 1) - at(k), {0, 0, 1}, 1, 1);
    for (int k = 0; k < facets; ++k) {
        const auto index = static_cast<std::uint32_t>(column.size());
        column.positions.push_back((at(k) + at(k + 1) + Vec3{0, 0, 3}) / 3.0);
        column.normals.push_back({0, 0, 1});
        column.radii.push_back(1.0);
        column.areas.push_back(0.5 * std::sin(2 * pi / facets));
        column.triangles.push_back({{0, 0, 1}, at(k) + Vec3{0, 0, 1}, at(k + 1) + Vec3{0, 0, 1}, index});
    }
    shapes::finish(column, 0.5, 0.0);
    const CompiledScene compiled(shapes::scene_of({column}));
    const PatchCorners corners = patch_corners(compiled.scene(), compiled.tracer(), column.areas);
    // Upper and lower rim of the column, the rim of its end, and the middle of that.
    ASSERT_EQ(corners.means.rows(), 3u * facets + 1u);
    for (std::size_t row = 0; row < corners.means.rows(); ++row) {
        float sum = 0.0f;
        std::size_t count = 0, ends = 0;
        corners.means.for_row(row, [&](std::uint32_t i, float w) {
            sum += w;
            ++count;
            ends += i >= facets;
        });
        EXPECT_NEAR(sum, 1.0f, 1e-6);
        EXPECT_EQ(count, ends == facets ? static_cast<std::size_t>(facets) : 2u);
        EXPECT_TRUE(ends == 0 || ends == count);
    }
}

}  // namespace
}  // namespace surflux
