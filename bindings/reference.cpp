#include "surflux/reference/reference.h"
#include "convert.h"
#include "rooms.h"

namespace surflux::bindings {

namespace {

// Irradiance, its standard error, and the number of rays.
py::tuple irradiance_at_points(const CompiledScene& scene, const Doubles& points, const Doubles& normals,
                               std::size_t samples, std::uint64_t seed, double small_emitters,
                               const py::object& progress) {
    const std::vector<Vec3> at = to_vec3s(points, "points"), facing = to_vec3s(normals, "normals");
    const ReferenceOptions options{samples, seed, small_emitters};
    const Progress report = to_progress(progress);
    const Reference out = without_gil([&] { return reference_irradiance(scene, at, facing, options, report); });
    return py::make_tuple(to_array(out.irradiance), to_array(out.error), out.rays);
}

}  // namespace

void bind_reference(py::module_& module) {
    module.def("reference_irradiance", &irradiance_at_points, py::arg("scene"), py::arg("points"), py::arg("normals"),
               py::arg("samples"), py::arg("seed"), py::arg("small_emitters") = ReferenceOptions{}.small_emitters,
               py::arg("progress") = py::none());
}

}  // namespace surflux::bindings
