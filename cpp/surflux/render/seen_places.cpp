#include "surflux/render/seen_places.h"

#include <cmath>
#include <limits>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/render/pixel_places.h"

namespace surflux {

Vec3 onto_patch(const std::vector<Triangle>& triangles, std::uint32_t begin, std::uint32_t end, const Vec3& place) {
    Vec3 off;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::uint32_t k = begin; k < end; ++k) {
        const Triangle& t = triangles[k];
        const Vec3 across = cross(t.b - t.a, t.c - t.a);
        const double twice = length(across);
        if (!(twice > 0.0)) continue;
        const double distance = dot(across, place - t.a) / twice;
        if (std::abs(distance) >= nearest) continue;
        nearest = std::abs(distance);
        off = (distance / twice) * across;
    }
    return place - off;
}

std::vector<Vec3> seen_places(const Surfels& surfels, const Camera& camera, std::size_t width, std::size_t height,
                              std::size_t top, const std::vector<float>& depths,
                              const std::vector<std::int32_t>& indices) {
    require(indices.size() == depths.size() && width > 0 && depths.size() % width == 0,
            "indices: wanted one for each depth, in whole rows");
    const std::vector<std::uint32_t> triangles = triangle_ranges(surfels);
    const PixelRays rays(camera, width, height);
    std::vector<Vec3> out(depths.size());
    parallel_for(depths.size(), 4096, [&](std::size_t p) {
        if (indices[p] < 0) return;
        const auto surfel = static_cast<std::size_t>(indices[p]);
        require(surfel < surfels.size(), "indices: there is no surfel ", surfel);
        const auto x = static_cast<double>(p % width), y = static_cast<double>(top + p / width);
        const Vec3 place = rays.origin(x, y) + static_cast<double>(depths[p]) * rays.direction(x, y);
        out[p] = onto_patch(surfels.triangles, triangles[surfel], triangles[surfel + 1], place);
    });
    return out;
}

}  // namespace surflux
