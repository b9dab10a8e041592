#include "surflux/reference/reference.h"
#include "convert.h"
#include "rooms.h"
#include "surflux/reference/glossy_reference.h"
#include "team.h"

namespace surflux::bindings {

namespace {

// Irradiance, its standard error, and the number of rays.
py::tuple irradiance_at_points(const CompiledScene& scene, const Doubles& points, const Doubles& normals,
                               std::size_t samples, std::uint64_t seed, double small_emitters,
                               const py::object& progress, const py::object& team) {
    const std::vector<Vec3> at = to_vec3s(points, "points"), facing = to_vec3s(normals, "normals");
    const ReferenceOptions options{samples, seed, small_emitters, to_team(team)};
    const Progress report = to_progress(progress);
    const Reference out = without_gil([&] { return reference_irradiance(scene, at, facing, options, report); });
    return py::make_tuple(to_array(out.irradiance), to_array(out.error), out.rays);
}

// Radiance, its standard error, and the number of rays. Materials that are None are those of the surfels.
py::tuple radiance_at_points(const CompiledScene& scene, const Doubles& points, const Doubles& normals,
                             const Doubles& directions, const std::optional<Doubles>& reflectance,
                             const std::optional<Doubles>& specular, const std::optional<Doubles>& exponent,
                             bool glossy_bounces, std::size_t samples, std::uint64_t seed, const py::object& progress) {
    GlossyPlaces places{
        to_vec3s(points, "points"), to_vec3s(normals, "normals"), to_vec3s(directions, "directions"), {}, {}, {}};
    if (reflectance) places.reflectance = to_vec3s(*reflectance, "reflectance");
    if (specular) places.specular = to_vec3s(*specular, "specular");
    if (exponent) places.exponents = to_vector(*exponent);
    GlossyOptions options;
    options.samples = samples;
    options.seed = seed;
    options.glossy_bounces = glossy_bounces;
    const Progress report = to_progress(progress);
    const Reference out = without_gil([&] { return reference_radiance(scene, places, options, report); });
    return py::make_tuple(to_array(out.irradiance), to_array(out.error), out.rays);
}

}  // namespace

void bind_reference(py::module_& module) {
    module.def("reference_irradiance", &irradiance_at_points, py::arg("scene"), py::arg("points"), py::arg("normals"),
               py::arg("samples"), py::arg("seed"), py::arg("small_emitters") = ReferenceOptions{}.small_emitters,
               py::arg("progress") = py::none(), py::arg("team") = py::none());
    module.def("reference_radiance", &radiance_at_points, py::arg("scene"), py::arg("points"), py::arg("normals"),
               py::arg("directions"), py::arg("reflectance"), py::arg("specular"), py::arg("exponent"),
               py::arg("glossy_bounces"), py::arg("samples"), py::arg("seed"), py::arg("progress") = py::none());
}

}  // namespace surflux::bindings
