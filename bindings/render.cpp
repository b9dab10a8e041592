#include "convert.h"
#include "pictures.h"
#include "rooms.h"

#include "surflux/gl/context.h"
#include "surflux/render/splat.h"

namespace surflux::bindings {

namespace {

py::dict render_splats(const Surfels& surfels, const Doubles& radiance, const std::vector<EmitterArrays>& emitters,
                       const CameraArrays& camera, std::size_t width, std::size_t height, const Doubles& background,
                       double footprint, int samples,
                       const py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>& objects) {
    const std::vector<Rgb> colors = to_vec3s(radiance, "radiance");
    const std::vector<VisibleEmitter> lamps = to_emitters(emitters);
    const Camera view = to_camera(camera);
    const SplatOptions options{to_vec3(background, "background"), footprint, samples, to_vector(objects)};
    const SplatImage image =
        without_gil([&] { return splat_image(surfels, colors, lamps, view, width, height, options); });
    py::dict out;
    out["radiance"] = to_pixels(image.radiance, height, width, 3);
    out["coverage"] = to_pixels(image.coverage, height, width, 1);
    out["depth"] = to_pixels(image.depth, height, width, 1);
    out["normal"] = to_pixels(image.normal, height, width, 3);
    out["index"] = to_pixels(image.index, height, width, 1);
    return out;
}

py::dict gl_info() {
    const gl::Description found = without_gil([&] { return gl::describe(); });
    py::dict out;
    out["api"] = found.api;
    out["vendor"] = found.vendor;
    out["renderer"] = found.renderer;
    out["version"] = found.version;
    return out;
}

}  // namespace

void bind_render(py::module_& module) {
    module.def("render_splats", &render_splats, py::arg("surfels"), py::arg("radiance"), py::arg("emitters"),
               py::arg("camera"), py::arg("width"), py::arg("height"), py::arg("background"), py::arg("footprint"),
               py::arg("samples"), py::arg("objects") = py::array_t<std::int32_t>(0));
    module.def("gl_info", &gl_info);
}

}  // namespace surflux::bindings
