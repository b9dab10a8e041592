#include "surflux/neighbors/normals.h"

#include <optional>

#include "convert.h"
#include "rooms.h"
#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"
#include "surflux/neighbors/on_surface.h"
#include "surflux/neighbors/point_index.h"
#include "surflux/neighbors/radii.h"
#include "surflux/neighbors/sample_elimination.h"
#include "surflux/neighbors/strays.h"
#include "surflux/scene/sample_triangles.h"
#include "surflux/scene/surfels.h"

namespace surflux::bindings {

namespace {

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
        "morton_order",
        [](const Doubles& points) {
            const std::vector<Vec3> p = to_vec3s(points, "points");
            return to_array(without_gil([&] { return morton_order(p); }));
        },
        py::arg("points"));
    module.def(
        "estimate_normals",
        [](const Doubles& points, std::size_t neighbors, const std::optional<Doubles>& viewpoint,
           const py::object& progress) {
            NormalOptions options;
            options.neighbors = neighbors;
            if (viewpoint) options.viewpoint = to_vec3(*viewpoint, "viewpoint");
            const std::vector<Vec3> p = to_vec3s(points, "points");
            const Progress report = to_progress(progress);
            const std::vector<Vec3> normals = without_gil([&] { return estimate_normals(p, options, report); });
            return to_array(normals);
        },
        py::arg("points"), py::arg("neighbors"), py::arg("viewpoint"), py::arg("progress") = py::none());
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
            const std::vector<Vec3> p = to_vec3s(points, "points");
            const Progress report = to_progress(progress);
            const std::vector<std::uint32_t> kept =
                without_gil([&] { return eliminate_samples(p, count, area, seed, report); });
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
    module.def("sample_triangles", [](const Doubles& triangles, std::size_t count, std::uint64_t seed) {
        require(triangles.size() % 9 == 0, "triangles: wanted shape (t, 3, 3)");
        std::vector<std::array<Vec3, 3>> t(static_cast<std::size_t>(triangles.size()) / 9);
        if (!t.empty()) std::memcpy(static_cast<void*>(t.data()), triangles.data(), t.size() * sizeof(t[0]));
        std::vector<Vec3> positions;
        std::vector<std::uint32_t> indices;
        {
            py::gil_scoped_release release;
            for (const SurfacePoint& s : sample_triangles(t, count, seed)) {
                positions.push_back(s.position);
                indices.push_back(s.triangle);
            }
        }
        return py::make_tuple(to_array(positions), to_array(indices));
    });
}

}  // namespace surflux::bindings
