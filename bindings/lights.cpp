#include "convert.h"
#include "rooms.h"

#include "surflux/lights/sky_patches.h"

namespace surflux::bindings {

void bind_lights(py::module_& module) {
    py::class_<SkyPatches>(module, "SkyPatches")
        .def(py::init<int>(), py::arg("subdivision"))
        .def("__len__", &SkyPatches::size)
        .def_property_readonly("directions", [](const SkyPatches& p) { return to_array(p.directions()); })
        .def_property_readonly("solid_angles", [](const SkyPatches& p) { return to_array(p.solid_angles()); })
        .def("index",
             [](const SkyPatches& p, const Doubles& directions) {
                 std::vector<std::uint32_t> out;
                 for (const Vec3& d : to_vec3s(directions, "directions"))
                     out.push_back(static_cast<std::uint32_t>(p.index_of(d)));
                 return to_array(out);
             })
        .def("radiance", [](const SkyPatches& p, const Environment& environment) {
            return to_array(without_gil([&] { return patch_radiances(environment, p); }));
        });
}

}  // namespace surflux::bindings
