#include "convert.h"
#include "rooms.h"

#include <Eigen/Core>

#include "surflux/core/parallel.h"
#include "surflux/neighbors/point_index.h"
#include "surflux/trace/tracer.h"

namespace surflux::bindings {

namespace {

py::dict versions() {
    py::dict out;
    out["Embree"] = embree_version();
    out["FLANN"] = flann_version();
    out["oneTBB"] = tbb_version();
    out["Eigen"] = message(EIGEN_WORLD_VERSION, ".", EIGEN_MAJOR_VERSION, ".", EIGEN_MINOR_VERSION);
    return out;
}

}  // namespace

PYBIND11_MODULE(_core, module) {
    module.doc() = "The compiled core of surflux. Use the package surflux, which checks what it hands in here.";

    py::register_exception<FileError>(module, "FileError", PyExc_OSError);
    py::register_exception<Cancelled>(module, "Cancelled");
    py::register_exception<DeviceError>(module, "DeviceError", PyExc_RuntimeError);
    py::class_<ThreadLimit>(module, "ThreadLimit").def(py::init<int>());

    bind_files(module);
    module.def("version", [] { return SURFLUX_VERSION; });
    module.def("versions", &versions);

    bind_scene(module);
    bind_scene_arrays(module);
    bind_neighbors(module);
    bind_area(module);
    bind_trace(module);
    bind_lights(module);
    bind_reference(module);
    bind_solution(module);
    bind_radiosity(module);
    bind_meshless(module);
    bind_transfer(module);
    bind_harmonics(module);
    bind_tone_map(module);
    bind_render(module);
    bind_lamp_view(module);
}

}  // namespace surflux::bindings
