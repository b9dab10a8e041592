#include "surflux/meshless/point_placement.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"
#include "surflux/meshless/disk_fill.h"
#include "surflux/meshless/point_grid.h"

namespace surflux {

namespace {

constexpr double usual_points = 400.0, least_points = 32.0;
constexpr double packing = 0.7;  // points on a square of side R: disks of diameter R jam at a share of .547
constexpr double most_points = 1e9;
constexpr double cell_side = 2.0;  // in R
// Cubic cells of side R that the surface of an object may lie in, counted at so many places of it. A plane has up to
// sqrt(3) of them for each R^2, with usual_points about 1000; a wire that has no more is up to 1600 R long.
constexpr std::size_t most_cells = 1600, counted_places = 4096;
constexpr double wider = 1.25;

// Places spread over an object in proportion to area, from the first.
std::vector<Vec3> spread_places(const SurfacePieces& pieces, std::size_t object) {
    std::vector<Vec3> out;
    out.reserve(counted_places);
    const double step = pieces.area_of(object) / static_cast<double>(counted_places);
    double up_to = 0.0;
    for (const std::uint32_t piece : pieces.of_object(object)) {
        up_to += pieces.area(piece);
        const Corners t = pieces.corners(piece);
        while (out.size() < counted_places && (static_cast<double>(out.size()) + 0.5) * step < up_to) {
            Random random(out.size(), object);
            const double u = random.uniform();
            const Vec3 w = square_to_triangle(u, random.uniform());
            out.push_back(w.x * t.a + w.y * t.b + w.z * t.c);
        }
    }
    for (std::size_t k = out.size(); k-- > 0;) out[k] = out[k] - out[0];
    return out;
}

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
double first_radius(const SurfacePieces& pieces, std::size_t object, double points) {
    double radius = std::sqrt(packing * pieces.area_of(object) / points);
    const std::vector<Vec3> places = spread_places(pieces, object);
    while (count_cells(places, radius) > most_cells) radius *= wider;
    return radius;
}

std::vector<double> first_radii(const SurfacePieces& pieces, double given) {
    std::vector<double> out(pieces.objects(), 0.0);
    double total = 0.0;
    for (std::size_t o = 0; o < out.size(); ++o) total += pieces.area_of(o);
    for (std::size_t o = 0; o < out.size(); ++o) {
        const double area = pieces.area_of(o);
        const double points = std::max(least_points, usual_points * area / total);
        if (!(area > 0.0)) continue;
        out[o] = given > 0.0 ? given : first_radius(pieces, o, points);
    }
    return out;
}

}  // namespace

PointPlacement::PointPlacement(const Scene& scene, const Tracer& tracer, const PlacementOptions& options)
    : scene_(scene), tracer_(tracer), options_(options), pieces_(scene) {
    require(options.radius >= 0.0 && std::isfinite(options.radius), "radius: wanted a positive number, or 0, got ",
            options.radius);
    require(options.rejections >= 1, "rejections: wanted at least 1, got ", options.rejections);
    points_.first_radius = first_radii(pieces_, options.radius);
    points_.level_begin = {0};
}

void PointPlacement::add_level(const Wanted& wanted, const Progress& progress) {
    const std::size_t level = points_.level_begin.size() - 1, objects = pieces_.objects(), before = points_.size();
    const double shrunk = std::pow(0.5, static_cast<double>(level));
    double total = 0.0, done = 0.0;
    for (std::size_t o = 0; o < objects; ++o) {
        const double r = points_.first_radius[o] * shrunk, area = pieces_.area_of(o);
        require(area <= most_points * r * r / packing, "radius: ", r, " is too small for level ", level, " of object ",
                o, ": its area ", area, " has room for more than ", most_points, " points");
        total += area;
    }

    std::vector<std::size_t> begin(objects + 1, 0);
    for (const std::uint32_t o : points_.objects) ++begin[o + 1];
    for (std::size_t o = 0; o < objects; ++o) begin[o + 1] += begin[o];
    std::vector<std::uint32_t> of_object(before);
    std::vector<std::size_t> to(begin.begin(), begin.end() - 1);
    for (std::uint32_t i = 0; i < before; ++i) of_object[to[points_.objects[i]]++] = i;

    const Vec3 low = bounds_of(scene_.surfels).low;
    std::vector<std::vector<FilledPoint>> filled(objects);
    for (std::size_t o = 0; o < objects; ++o) {
        if (points_.first_radius[o] == 0.0) continue;
        const double radius = points_.first_radius[o] * shrunk, area = pieces_.area_of(o);
        PointGrid grid(low, cell_side * radius, static_cast<std::size_t>(packing * area / (radius * radius)));
        std::vector<PointGrid::Point> there;
        there.reserve(begin[o + 1] - begin[o]);
        for (std::size_t k = begin[o]; k < begin[o + 1]; ++k) {
            const std::uint32_t i = of_object[k];
            there.push_back({points_.positions[i], points_.normals[i], i});
        }
        grid.insert(there);
        there = {};
        const std::uint64_t seed = Random(Random(options_.seed, level).bits(), o).bits();
        const Fill fill{scene_, tracer_, pieces_, o, radius, options_.rejections, seed, wanted};
        const Progress in_object = [&](std::size_t part, std::size_t of) {
            const double all = (done + area * static_cast<double>(part) / static_cast<double>(of)) / total;
            return progress(std::min<std::size_t>(999, static_cast<std::size_t>(all * 1000.0)), 1000);
        };
        filled[o] = fill_disks(fill, grid, progress ? in_object : progress);
        done += area;
    }
    report(progress, 1000, 1000);

    std::size_t count = before;
    for (const auto& points : filled) count += points.size();
    points_.positions.reserve(count);
    points_.normals.reserve(count);
    points_.surfels.reserve(count);
    points_.objects.reserve(count);
    for (std::size_t o = 0; o < objects; ++o)
        for (const FilledPoint& p : filled[o]) {
            points_.positions.push_back(p.position);
            points_.normals.push_back(scene_.surfels.normals[p.surfel]);
            points_.surfels.push_back(p.surfel);
            points_.objects.push_back(static_cast<std::uint32_t>(o));
        }
    points_.level_begin.push_back(count);
}

}  // namespace surflux
