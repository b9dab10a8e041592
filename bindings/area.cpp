#include "convert.h"
#include "rooms.h"
#include "surflux/area/effective_area.h"
#include "surflux/area/quadrature.h"

namespace surflux::bindings {

void bind_area(py::module_& module) {
    py::enum_<AreaBackend>(module, "AreaBackend")
        .value("auto", AreaBackend::automatic)
        .value("cpu", AreaBackend::cpu)
        .value("gl", AreaBackend::gl);
    module.def(
        "effective_areas",
        [](const Surfels& surfels, bool curved, double kappa, int resolution, double epsilon,
           AreaBackend backend, const py::object& progress) {
            const AreaOptions options{curved ? AreaMethod::curved : AreaMethod::paper, kappa, resolution, epsilon,
                                      backend};
            const Progress report = to_progress(progress);
            const std::vector<double> areas = without_gil([&] { return effective_areas(surfels, options, report); });
            return to_array(areas);
        },
        py::arg("surfels"), py::arg("curved"), py::arg("kappa"), py::arg("resolution"), py::arg("epsilon"),
        py::arg("backend"), py::arg("progress") = py::none());
    module.def("instruction_set", &instruction_set);
}

}  // namespace surflux::bindings
