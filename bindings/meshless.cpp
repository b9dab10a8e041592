#include "convert.h"
#include "rooms.h"
#include "surflux/meshless/point_placement.h"

namespace surflux::bindings {

namespace {

// Of a scene whose `wanted` is a function of positions, normals and objects one by one, or None.
py::dict place_points(const Scene& scene, int levels, double radius, std::uint64_t seed, int rejections,
                      const py::object& wanted, const py::object& progress) {
    Wanted ask;
    if (!wanted.is_none())
        ask = [&wanted](const Vec3& p, const Vec3& n, std::uint32_t object) {
            const py::gil_scoped_acquire gil;
            return wanted(py::make_tuple(p.x, p.y, p.z), py::make_tuple(n.x, n.y, n.z), object).cast<bool>();
        };
    const Progress report = to_progress(progress);
    const PlacedPoints points = without_gil([&] {
        const Tracer tracer(scene);
        PointPlacement placement(scene, tracer, {radius, rejections, seed});
        // Only the last level is placed where it is wanted.
        for (int level = 0; level < levels; ++level) placement.add_level(level + 1 == levels ? ask : Wanted(), report);
        return placement.points();
    });
    py::dict out;
    out["positions"] = to_array(points.positions);
    out["normals"] = to_array(points.normals);
    out["surfels"] = to_array(points.surfels);
    out["objects"] = to_array(points.objects);
    out["level_begin"] = to_array(std::vector<std::int64_t>(points.level_begin.begin(), points.level_begin.end()));
    out["radii"] = to_array(points.first_radius);
    return out;
}

}  // namespace

void bind_meshless(py::module_& module) {
    module.def("place_points", &place_points, py::arg("scene"), py::arg("levels"), py::arg("radius") = 0.0,
               py::arg("seed") = 0, py::arg("rejections") = PlacementOptions{}.rejections,
               py::arg("wanted") = py::none(), py::arg("progress") = py::none());
}

}  // namespace surflux::bindings
