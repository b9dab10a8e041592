#include "surflux/trace/onto_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double rounding = 2.0 * std::numeric_limits<float>::epsilon();  // of coordinates that went through floats

double largest_coordinate(const Vec3& p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); }

}  // namespace

std::vector<Vec3> onto_surface(const Surfels& surfels, const Tracer& tracer, const std::vector<Vec3>& points,
                               const std::vector<Vec3>& normals, double farthest) {
    tracer.require_near(points);
    std::vector<Vec3> out = points;
    parallel_for(points.size(), 64, [&](std::size_t k) {
        const Departure from = tracer.departure(points[k], normals[k]);
        if (from.surfel != Hit::none) return;
        const Hit above = tracer.closest(Ray{from, from.normal});
        const auto faces_its_way = [&](const Hit& hit) {
            return hit && dot(surfels.normals[hit.surfel], from.normal) > 0.0;
        };
        if (above && !faces_its_way(above)) {  // the other side of a sheet?
            const double radius = surfels.radii[above.surfel];
            const double rounded = std::min(rounding * largest_coordinate(points[k]), farthest * radius);
            if (above.distance > std::max(by_rounding * radius, rounded)) return;
            const Vec3 place = points[k] + above.distance * from.normal;
            if (tracer.departure(place, from.normal).surfel != Hit::none) out[k] = place;
            return;
        }
        if (!above || above.distance > farthest * surfels.radii[above.surfel]) return;
        const Hit below = tracer.closest(Ray{from, -from.normal});
        if (faces_its_way(below) && below.distance < above.distance) return;
        out[k] = points[k] + above.distance * from.normal;
    });
    return out;
}

}  // namespace surflux
