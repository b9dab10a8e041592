#include "surflux/meshless/point_placement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "surflux/core/error.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/core/span.h"
#include "surflux/meshless/dart_throwing.h"

namespace surflux {

namespace {

constexpr double packing = 0.7;  // points on a square of side R: disks of diameter R jam at a share of .547
constexpr double most_points = 1e9;

// Places spread over an object in proportion to area, from the first.
std::vector<Vec3> spread_places(const Scene& scene, Span<Triangle> surface, double area, std::size_t counted_places) {
    std::vector<Vec3> out;
    out.reserve(counted_places);
    const double step = area / static_cast<double>(counted_places);
    double up_to = 0.0;
    for (const Triangle& t : surface) {
        up_to += surface_area(scene, t);
        while (out.size() < counted_places && (static_cast<double>(out.size()) + 0.5) * step < up_to) {
            Random random(out.size(), scene.object[t.surfel]);
            const double u = random.uniform();
            const Vec3 w = square_to_triangle(u, random.uniform());
            out.push_back(w.x * t.a + w.y * t.b + w.z * t.c);
        }
    }
    for (std::size_t k = out.size(); k-- > 0;) out[k] = out[k] - out[0];
    return out;
}

// Cubic cells of that side that the surface lies in. A plane has up to sqrt(3) of them for each R^2, with 400 points
// about 1000; a wire that has no more than 1600 is up to 1600 R long.
std::size_t count_cells(const std::vector<Vec3>& places, double side) {
    std::vector<std::array<double, 3>> cells(places.size());
    for (std::size_t k = 0; k < places.size(); ++k)
        for (int axis = 0; axis < 3; ++axis)
            cells[k][static_cast<std::size_t>(axis)] = std::floor(places[k][axis] / side);
    std::sort(cells.begin(), cells.end());
    return static_cast<std::size_t>(std::unique(cells.begin(), cells.end()) - cells.begin());
}

// For so many points. On a wire, or on leaves that lie apart, as many would have to be closer together than they are
// far from what is around: there it is wider. What counts is where the area is, not how far a stray piece reaches.
double first_radius(const std::vector<Vec3>& places, double area, double points, const MeshlessTuning& tuning) {
    const std::size_t most_cells = whole_number(tuning.most_cells);
    double radius = std::sqrt(packing * area / points);
    while (count_cells(places, radius) > most_cells) radius *= 1.0 + tuning.wider_by;
    return radius;
}

}  // namespace

PointPlacement::PointPlacement(const Scene& scene, const Tracer& tracer, const PlacementOptions& options)
    : scene_(scene), tracer_(tracer), options_(options), surface_(scene) {
    require(options.radius >= 0.0 && std::isfinite(options.radius), "radius: wanted a positive number, or 0, got ",
            options.radius);
    const MeshlessTuning& tuning = options_.tuning;
    const std::size_t counted_places = whole_number(tuning.counted_places);
    const double total = std::accumulate(surface_.area.begin(), surface_.area.end(), 0.0);
    points_.first_radius.assign(surface_.area.size(), 0.0);
    const Triangle *begin = surface_.triangles.data(), *const end = begin + surface_.triangles.size();
    while (begin < end) {
        const std::uint32_t o = scene.object[begin->surfel];
        const Triangle* next = std::find_if(begin, end, [&](const Triangle& t) { return scene.object[t.surfel] != o; });
        const double area = surface_.area[o],
                     points = std::max(tuning.least_points, tuning.coarsest_points * area / total);
        points_.first_radius[o] =
            options.radius > 0.0
                ? options.radius
                : first_radius(spread_places(scene, {begin, next}, area, counted_places), area, points, tuning);
        begin = next;
    }
    points_.level_begin = {0};
}

void PointPlacement::add_level(const SignedDistance& region, const Progress& progress) {
    const std::size_t level = points_.level_begin.size() - 1;
    std::vector<double> radius;
    for (std::size_t o = 0; o < surface_.area.size(); ++o) {
        const double r = std::ldexp(points_.first_radius[o], -static_cast<int>(level));
        require(surface_.area[o] <= most_points * r * r / packing, "radius: ", r, " is too small for level ", level,
                " of object ", o, ": its area ", surface_.area[o], " has room for more than ", most_points, " points");
        radius.push_back(r);
    }
    std::vector<PointGrid::Point> there;
    for (std::size_t i = 0; i < points_.size(); ++i)
        there.push_back({points_.positions[i], points_.normals[i], points_.objects[i]});
    std::vector<PointGrid::Point> added =
        throw_darts(scene_, tracer_, surface_, there,
                    {radius, Random(options_.seed, level).bits(), region, options_.tuning}, progress);
    std::stable_sort(added.begin(), added.end(), [](const auto& a, const auto& b) { return a.object < b.object; });
    for (const PointGrid::Point& p : added) {
        points_.positions.push_back(p.position);
        points_.normals.push_back(p.normal);
        points_.surfels.push_back(p.surfel);
        points_.objects.push_back(p.object);
    }
    points_.level_begin.push_back(points_.size());
}

}  // namespace surflux
