#pragma once

#include <pybind11/pybind11.h>

// One function and one file per room of cpp/surflux.
namespace surflux::bindings {

void bind_files(pybind11::module_& module);
void bind_scene(pybind11::module_& module);
void bind_scene_arrays(pybind11::module_& module);
void bind_neighbors(pybind11::module_& module);
void bind_area(pybind11::module_& module);
void bind_trace(pybind11::module_& module);
void bind_lights(pybind11::module_& module);
void bind_reference(pybind11::module_& module);
void bind_solution(pybind11::module_& module);
void bind_radiosity(pybind11::module_& module);
void bind_meshless(pybind11::module_& module);
void bind_transfer(pybind11::module_& module);
void bind_harmonics(pybind11::module_& module);
void bind_tone_map(pybind11::module_& module);
void bind_render(pybind11::module_& module);
void bind_lamp_view(pybind11::module_& module);

}  // namespace surflux::bindings
