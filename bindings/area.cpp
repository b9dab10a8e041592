#include <algorithm>

#include "convert.h"
#include "rooms.h"
#include "surflux/area/effective_area.h"
#include "surflux/area/quadrature.h"
#include "surflux/area/shares.h"

namespace surflux::bindings {

void bind_area(py::module_& module) {
    py::enum_<AreaBackend>(module, "AreaBackend")
        .value("auto", AreaBackend::automatic)
        .value("cpu", AreaBackend::cpu)
        .value("gl", AreaBackend::gl);
    module.def(
        "effective_areas",
        [](const Surfels& surfels, bool curved, double kappa, int resolution, double epsilon, AreaBackend backend,
           const py::object& progress) {
            const AreaOptions options{curved ? AreaMethod::curved : AreaMethod::paper, kappa, resolution, epsilon,
                                      backend};
            const Progress report = to_progress(progress);
            const std::vector<double> areas = without_gil([&] { return effective_areas(surfels, options, report); });
            return to_array(areas);
        },
        py::arg("surfels"), py::arg("curved"), py::arg("kappa"), py::arg("resolution"), py::arg("epsilon"),
        py::arg("backend"), py::arg("progress") = py::none());
    module.def(
        "area_shares",
        [](const Surfels& surfels, std::size_t index, bool curved, double kappa, int resolution, double epsilon) {
            const AreaOptions options{curved ? AreaMethod::curved : AreaMethod::paper, kappa, resolution, epsilon};
            const DiskShares found = without_gil([&] { return area_shares(surfels, index, options); });
            const auto m = static_cast<py::ssize_t>(found.members.size());
            return py::make_tuple(to_array(found.members),
                                  to_array(found.shares).reshape({m, py::ssize_t{resolution}, py::ssize_t{resolution}}),
                                  to_array(std::vector<Vec3>{found.frame.u, found.frame.v, found.frame.n}),
                                  found.extent, found.area);
        },
        py::arg("surfels"), py::arg("index"), py::arg("curved"), py::arg("kappa"), py::arg("resolution"),
        py::arg("epsilon"));
    module.def("instruction_set", &instruction_set);
}

}  // namespace surflux::bindings
