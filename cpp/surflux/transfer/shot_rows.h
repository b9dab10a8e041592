#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "surflux/core/vec.h"
#include "surflux/lights/sample_points.h"

namespace surflux {

// Rows of a transport operator as rays find them, while it is built: a link counts the rays of the first and of the
// second half of its row apart, for these are two estimates, whose difference tells the variance.
struct ShotRows {
    struct Link {
        std::uint32_t sender;
        std::uint8_t first, second;  // 255 together, at most
        std::int8_t u, v;            // mean slopes of the rays in the tangent plane, in units of 1 / slope_scale
    };
    struct Row {
        std::uint32_t begin = 0, end = 0;  // links
        float per_ray = 0.0f;              // share of the cosine-weighted hemisphere
        float u = 0.0f, v = 0.0f;          // mean slopes of all rays: not quite 0, which is taken off
        // Of the rays those that leave the scene, and that end on backs: shares, in units of 1 / share_scale.
        std::uint16_t escape = 0, into_backs = 0;
    };
    // Slopes are 1 / cos, and their mean square does not exist: beyond `steepest` they are cut.
    static constexpr float slope_scale = 15.0f, steepest = 8.0f;
    static constexpr std::size_t most_rays = 255;  // of one link
    static constexpr float share_scale = 65535.0f;

    std::vector<Vec3> positions, normals;        // of receivers
    std::vector<std::uint32_t> surfels, shapes;  // that they lie on, and are
    Place place(std::size_t row) const { return {positions[row], normals[row], surfels[row], shapes[row]}; }

    std::vector<Row> rows;
    std::vector<Link> links;
    std::size_t rays = 0;
};

}  // namespace surflux
