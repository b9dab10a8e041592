#include "surflux/render/reach.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/render/principal_axes.h"

namespace surflux {

namespace {

// Estimated radii just close a plane; where the surface bends, single pixels would stay open.
constexpr double closing = 1.15;

// Kernels of long faces, over the root of their area: those of slivers would lend light from far away along them.
constexpr double longest = 1.5;
constexpr double least = 0.4;      // over their length: by the usual footprint of 1.5 they reach beyond their ends
constexpr double thinnest = 1e-3;  // over their length

// Of the patch of some triangles, of that area together.
Reach of_patch(const Vec3& center, const Vec3& normal, const Triangle* begin, const Triangle* end, double area) {
    const Frame frame = frame_around(normal);
    double uu = 0.0, uv = 0.0, vv = 0.0;
    for (const Triangle* t = begin; t != end; ++t) {
        const Vec3 a = t->a - center, b = t->b - center, c = t->c - center, sum = a + b + c;
        const double weight = area_of(*t);
        for (const Vec3& p : {a, b, c, sum}) {
            const double u = dot(p, frame.u), v = dot(p, frame.v);
            uu += weight * u * u, uv += weight * u * v, vv += weight * v * v;
        }
    }
    // Moments are a twelfth of these: of a square of side 1 they are 1 / 12.
    const PrincipalAxes e = principal_axes(uu / area, uv / area, vv / area);
    const double whole = std::sqrt(e.along),
                 along = std::min(whole, std::max(least * whole, longest * std::sqrt(area)));
    return {0.0, e.x * frame.u + e.y * frame.v, along, std::max(std::sqrt(std::max(e.across, 0.0)), thinnest * along)};
}

}  // namespace

std::vector<Reach> reaches(const Surfels& surfels) {
    const std::vector<std::uint32_t> triangles = triangle_ranges(surfels);
    std::vector<Reach> out(surfels.size());
    parallel_for(out.size(), 4096, [&](std::size_t i) {
        const Triangle *begin = surfels.triangles.data() + triangles[i],
                       *end = surfels.triangles.data() + triangles[i + 1];
        double area = 0.0;
        for (const Triangle* t = begin; t != end; ++t) area += area_of(*t);
        if (area > 0.0) {
            out[i] = of_patch(surfels.positions[i], surfels.normals[i], begin, end, area);
            return;
        }
        double disk = surfels.radii[i], kernel = disk;
        if (!surfels.areas.empty()) {
            const double even = 1.4 * std::sqrt(surfels.areas[i]);
            kernel = std::min(2.0 * disk, even), disk = std::min(closing * disk, even);
        }
        out[i] = {disk, frame_around(surfels.normals[i]).u, kernel, kernel};
    });
    return out;
}

}  // namespace surflux
