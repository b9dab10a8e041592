#include "convert.h"
#include "rooms.h"

#include "surflux/core/parallel.h"

namespace surflux::bindings {

PYBIND11_MODULE(_core, module) {
    module.doc() = "The compiled core of surflux. Use the package surflux, which checks what it hands in here.";

    py::register_exception<FileError>(module, "FileError", PyExc_OSError);
    py::register_exception<Cancelled>(module, "Cancelled");
    py::register_exception<DeviceError>(module, "DeviceError", PyExc_RuntimeError);
    py::class_<ThreadLimit>(module, "ThreadLimit").def(py::init<int>());

    bind_files(module);
    bind_scene(module);
    bind_neighbors(module);
    bind_area(module);
    bind_radiosity(module);
    bind_image(module);
    bind_render(module);
}

}  // namespace surflux::bindings
