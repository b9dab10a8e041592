#include "convert.h"
#include "rooms.h"
#include "surflux/trace/inward.h"

namespace surflux::bindings {

void bind_trace(py::module_& module) {
    module.def(
        "inward_patches",
        [](const Surfels& surfels, int rays, std::size_t smallest, std::uint64_t seed, const py::object& progress) {
            const InwardOptions options{rays, smallest, seed};
            const Progress report = to_progress(progress);
            return to_array(without_gil([&] { return inward_patches(surfels, options, report); }));
        },
        py::arg("surfels"), py::arg("rays"), py::arg("smallest"), py::arg("seed"), py::arg("progress") = py::none());
}

}  // namespace surflux::bindings
