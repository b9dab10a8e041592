#include <algorithm>

#include "convert.h"
#include "rooms.h"
#include "surflux/area/disk_ends.h"
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
        "with_disk_ends",
        [](const Surfels& surfels, const py::object& progress) {
            const Progress report = to_progress(progress);
            return without_gil([&] {
                Surfels out = surfels;
                find_disk_ends(out, AreaOptions{}.epsilon, report);
                return out;
            });
        },
        py::arg("surfels"), py::arg("progress") = py::none());
    // (areas, surfels with their ends)
    module.def(
        "areas_and_disk_ends",
        [](const Surfels& surfels, const py::object& progress) {
            const Progress report = to_progress(progress);
            Surfels out = surfels;
            const std::vector<double> areas = without_gil([&] { return find_areas_and_ends(out, report); });
            return py::make_tuple(to_array(areas), std::move(out));
        },
        py::arg("surfels"), py::arg("progress") = py::none());
    module.def("has_disks", [](const Surfels& surfels) {
        const std::vector<bool> is_disk = disks_among(surfels);
        return std::find(is_disk.begin(), is_disk.end(), true) != is_disk.end();
    });
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
