#include "surflux/meshless/point_placement.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/random.h"
#include "surflux/meshless/disk_fill.h"
#include "surflux/meshless/point_grid.h"

namespace surflux {

namespace {

constexpr double usual_points = 400.0, least_points = 32.0;
constexpr double packing = 0.7;  // points on a square of side R: disks of diameter R jam at a share of .547
constexpr double most_points = 1e9;
constexpr double most_along = 400.0;  // points of the first level, along a wire
constexpr double cell_side = 2.0;     // in R

std::vector<double> first_radii(const SurfacePieces& pieces, double given) {
    std::vector<double> out(pieces.objects(), 0.0);
    double total = 0.0;
    for (std::size_t o = 0; o < out.size(); ++o) total += pieces.area_of(o);
    for (std::size_t o = 0; o < out.size(); ++o) {
        const double area = pieces.area_of(o);
        const double points = std::max(least_points, usual_points * area / total);
        if (!(area > 0.0)) continue;
        Box box;
        bool first = true;
        for (const std::uint32_t piece : pieces.of_object(o)) {
            const Corners t = pieces.corners(piece);
            for (const Vec3* p : {&t.a, &t.b, &t.c}) {
                if (first) box = {*p, *p};
                first = false;
                for (int axis = 0; axis < 3; ++axis) {
                    box.low[axis] = std::min(box.low[axis], (*p)[axis]);
                    box.high[axis] = std::max(box.high[axis], (*p)[axis]);
                }
            }
        }
        out[o] = given > 0.0 ? given : std::max(std::sqrt(packing * area / points), box.diagonal() / most_along);
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
