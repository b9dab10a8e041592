#include "convert.h"
#include "rooms.h"
#include "surflux/core/parallel.h"
#include "surflux/lights/direct_at.h"
#include "surflux/solution/nodal_field.h"

namespace surflux::bindings {

namespace {

// A field of a solution, anywhere: values at its surfels.
struct Field {
    Field(const Surfels& surfels, const Indices& objects)
        : nodes(surfels.positions, surfels.normals, to_vector(objects)) {}

    py::array_t<double> at(const Doubles& values, const Doubles& points, const Doubles& normals) const {
        const std::vector<Rgb> known = to_vec3s(values, "values");
        const std::vector<Vec3> places = to_vec3s(points, "points"), facing = to_vec3s(normals, "normals");
        std::vector<Rgb> out(places.size());
        without_gil([&] {
            const NodalField::Values fitted = nodes.fit(known);
            parallel_blocks(places.size(), 64, [&](std::size_t begin, std::size_t end) {
                std::vector<Interpolation::Weight> near;
                for (std::size_t k = begin; k < end; ++k) {
                    nodes.interpolation().at(places[k], facing[k], Interpolation::any_object, near);
                    out[k] = nodes.at(fitted, places[k], facing[k], near);
                }
            });
            return 0;
        });
        return to_array(out);
    }

    NodalField nodes;
};

py::array_t<double> direct_at_points(const Scene& scene, const Doubles& points, const Doubles& normals, int probes,
                                     int shadow_rays, int rays, std::uint64_t seed) {
    const std::vector<Vec3> places = to_vec3s(points, "points"), facing = to_vec3s(normals, "normals");
    return to_array(without_gil([&] {
        const Tracer tracer(scene);
        return direct_at(scene, tracer, places, facing, {probes, shadow_rays}, rays, seed);
    }));
}

}  // namespace

void bind_solution(py::module_& module) {
    py::class_<Field>(module, "Field")
        .def(py::init<const Surfels&, const Indices&>(), py::arg("surfels"), py::arg("objects"))
        .def("at", &Field::at, py::arg("values"), py::arg("points"), py::arg("normals"));
    module.def("direct_at", &direct_at_points, py::arg("scene"), py::arg("points"), py::arg("normals"),
               py::arg("probes"), py::arg("shadow_rays"), py::arg("rays"), py::arg("seed"));
}

}  // namespace surflux::bindings
