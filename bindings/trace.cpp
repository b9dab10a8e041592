#include "convert.h"
#include "rooms.h"
#include "surflux/trace/inward.h"

namespace surflux::bindings {

void bind_trace(py::module_& module) {
    module.def(
        "inward_patches",
        [](const Surfels& surfels, std::size_t smallest, int rays, std::uint64_t seed, const py::object& progress) {
            const InwardOptions options{smallest, rays, seed};
            const Progress report = to_progress(progress);
            return to_array(without_gil([&] { return inward_patches(surfels, options, report); }));
        },
        py::arg("surfels"), py::arg("smallest"), py::arg("rays"), py::arg("seed"), py::arg("progress") = py::none());
}

}  // namespace surflux::bindings
