#include "surflux/neighbors/normals.h"

#include <optional>

#include "convert.h"
#include "rooms.h"
#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"
#include "surflux/neighbors/depth_steps.h"
#include "surflux/neighbors/on_surface.h"
#include "surflux/neighbors/point_index.h"
#include "surflux/neighbors/radii.h"
#include "surflux/neighbors/sample_elimination.h"
#include "surflux/neighbors/strays.h"
#include "surflux/scene/sample_triangles.h"
#include "surflux/scene/surfels.h"

namespace surflux::bindings {

namespace {

std::vector<std::array<Vec3, 3>> to_triangles(const Doubles& triangles) {
    require(triangles.size() % 9 == 0, "triangles: wanted shape (t, 3, 3)");
    std::vector<std::array<Vec3, 3>> out(static_cast<std::size_t>(triangles.size()) / 9);
    if (!out.empty()) std::memcpy(static_cast<void*>(out.data()), triangles.data(), out.size() * sizeof(out[0]));
    return out;
}

// Positions (n, 3), and which triangle (n,) each is on.
py::tuple points_on_triangles(const std::vector<SurfacePoint>& points) {
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> triangles;
    positions.reserve(points.size());
    triangles.reserve(points.size());
    for (const SurfacePoint& p : points) positions.push_back(p.position), triangles.push_back(p.triangle);
    return py::make_tuple(to_array(positions), to_array(triangles));
}

// The `count` nearest neighbours of every point, one row each, the point itself first and for padding.
std::vector<std::uint32_t> nearest_points(const std::vector<Vec3>& points, std::size_t count) {
    const PointIndex index(points);
    std::vector<std::uint32_t> rows(points.size() * count);
    parallel_for(points.size(), 256, [&](std::size_t i) {
        std::vector<Neighbor> found;
        index.nearest(points[i], count, found);
        for (std::size_t k = 0; k < count; ++k)
            rows[i * count + k] = k < found.size() ? found[k].index : static_cast<std::uint32_t>(i);
    });
    return rows;
}

}  // namespace

void bind_neighbors(py::module_& module) {
    module.def(
        "nearest_points",
        [](const Doubles& points, std::size_t count) {
            const std::vector<Vec3> p = to_vec3s(points, "points");
            return to_array(without_gil([&] { return nearest_points(p, count); }))
                .reshape({static_cast<py::ssize_t>(p.size()), static_cast<py::ssize_t>(count)});
        },
        py::arg("points"), py::arg("count"));
    module.def(
        "find_strays",
        [](const Doubles& places) {
            const std::vector<Vec3> p = to_vec3s(places, "places");
            return to_array(without_gil([&] { return find_strays(p); }));
        },
        py::arg("places"));
    module.def(
        "without_depth_steps",
        [](const Doubles& points, double step, const py::object& progress) {
            const std::vector<Vec3> p = to_vec3s(points, "points");
            const Progress report = to_progress(progress);
            const SmoothedDepth found = without_gil([&] { return without_depth_steps(p, step, report); });
            return py::make_tuple(to_array(found.points), to_array(found.is_off));
        },
        py::arg("points"), py::arg("step"), py::arg("progress") = py::none());
    module.def(
        "morton_order",
        [](const Doubles& points) {
            const std::vector<Vec3> p = to_vec3s(points, "points");
            return to_array(without_gil([&] { return morton_order(p); }));
        },
        py::arg("points"));
    module.def(
        "estimate_normals",
        [](const Doubles& points, std::size_t neighbors, const std::optional<Doubles>& viewpoint,
           const std::optional<py::array_t<bool, py::array::c_style | py::array::forcecast>>& wanted,
           const py::object& progress) {
            NormalOptions options;
            options.neighbors = neighbors;
            if (viewpoint) options.viewpoint = to_vec3(*viewpoint, "viewpoint");
            if (wanted) options.wanted.assign(wanted->data(), wanted->data() + wanted->size());
            const std::vector<Vec3> p = to_vec3s(points, "points");
            const Progress report = to_progress(progress);
            const std::vector<Vec3> normals = without_gil([&] { return estimate_normals(p, options, report); });
            return to_array(normals);
        },
        py::arg("points"), py::arg("neighbors"), py::arg("viewpoint"), py::arg("wanted") = py::none(),
        py::arg("progress") = py::none());
    module.def(
        "estimate_radii",
        [](const Doubles& points, const std::optional<Doubles>& normals, const py::object& progress) {
            const std::vector<Vec3> p = to_vec3s(points, "points");
            const std::vector<Vec3> n = normals ? to_vec3s(*normals, "normals") : std::vector<Vec3>();
            const Progress report = to_progress(progress);
            const std::vector<double> radii = without_gil([&] { return estimate_radii(p, n, report); });
            return to_array(radii);
        },
        py::arg("points"), py::arg("normals") = py::none(), py::arg("progress") = py::none());
    module.def(
        "eliminate_samples",
        [](const Doubles& points, std::size_t count, double area, std::uint64_t seed, const py::object& progress) {
            std::vector<Vec3> p = to_vec3s(points, "points");
            const Progress report = to_progress(progress);
            const std::vector<std::uint32_t> kept =
                without_gil([&] { return eliminate_samples(std::move(p), count, area, seed, report); });
            return to_array(kept);
        },
        py::arg("points"), py::arg("count"), py::arg("area"), py::arg("seed"), py::arg("progress") = py::none());
    py::class_<OnSurface>(module, "OnSurface")
        .def(py::init([](const Surfels& s) {
                 return without_gil([&] {
                     std::vector<double> extents(s.size(), 0.0);
                     for (const Triangle& t : s.triangles)
                         for (const Vec3& corner : {t.a, t.b, t.c})
                             extents[t.surfel] = std::max(extents[t.surfel], length(corner - s.positions[t.surfel]));
                     return std::make_unique<OnSurface>(s.positions, s.normals, s.radii, extents);
                 });
             }),
             py::arg("surfels"))
        .def(
            "__call__",
            [](const OnSurface& surface, const Doubles& points, const Doubles& normals) {
                const PointsAndNormals at = to_points_and_normals(points, normals);
                return to_array(without_gil([&] { return surface(at.points, at.normals); }));
            },
            py::arg("points"), py::arg("normals"));
    module.def(
        "sample_triangles",
        [](const Doubles& triangles, std::size_t count, std::uint64_t seed) {
            std::vector<std::array<Vec3, 3>> corners = to_triangles(triangles);
            return points_on_triangles(without_gil([&] {
                const TriangleSamples samples(std::move(corners), count, seed);
                std::vector<SurfacePoint> all(count);
                parallel_for(count, 4096, [&](std::size_t i) { all[i] = samples[i]; });
                return all;
            }));
        },
        py::arg("triangles"), py::arg("count"), py::arg("seed"));
    // Of `candidates` times as many points on the triangles those that eliminate_samples leaves.
    module.def(
        "sample_evenly",
        [](const Doubles& triangles, std::size_t count, std::size_t candidates, std::uint64_t seed,
           const py::object& progress) {
            std::vector<std::array<Vec3, 3>> corners = to_triangles(triangles);
            const Progress report = to_progress(progress);
            return points_on_triangles(without_gil([&] {
                const TriangleSamples samples(std::move(corners), candidates * count, seed);
                std::vector<Vec3> points(samples.size());
                parallel_for(
                    points.size(), 4096, [&](std::size_t i) { points[i] = samples[i].position; },
                    standing_at(0, 2 * points.size() - count, report));
                std::vector<SurfacePoint> kept;
                for (const std::uint32_t i : eliminate_samples(std::move(points), count, samples.area(), seed, report))
                    kept.push_back(samples[i]);
                return kept;
            }));
        },
        py::arg("triangles"), py::arg("count"), py::arg("candidates"), py::arg("seed"), py::arg("progress"));
}

}  // namespace surflux::bindings
