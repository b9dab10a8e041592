#include "convert.h"
#include "rooms.h"

#include "surflux/gl/context.h"
#include "surflux/render/splat.h"

namespace surflux::bindings {

namespace {

using EmitterArrays = std::tuple<Doubles, Doubles, Doubles, Doubles>;  // corner, u, v, radiance
using CameraArrays = std::tuple<Doubles, Doubles, Doubles, double>;    // eye, target, up, fov

template <class T>
py::array_t<T> pixels(const std::vector<T>& values, const SplatImage& image, py::ssize_t channels) {
    const auto height = static_cast<py::ssize_t>(image.height), width = static_cast<py::ssize_t>(image.width);
    py::array_t<T> out(channels == 1 ? std::vector<py::ssize_t>{height, width}
                                     : std::vector<py::ssize_t>{height, width, channels});
    std::memcpy(out.mutable_data(), values.data(), values.size() * sizeof(T));
    return out;
}

py::dict render_splats(const Surfels& surfels, const Doubles& radiance, const std::vector<EmitterArrays>& emitters,
                       const CameraArrays& camera, std::size_t width, std::size_t height, const Doubles& background,
                       double footprint, int samples,
                       const py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>& objects) {
    const std::vector<Rgb> colors = to_vec3s(radiance, "radiance");
    std::vector<VisibleEmitter> lamps;
    for (const auto& [corner, u, v, value] : emitters) {
        lamps.push_back(
            {to_vec3(corner, "corner"), to_vec3(u, "edge_u"), to_vec3(v, "edge_v"), to_vec3(value, "radiance")});
    }
    const auto& [eye, target, up, fov] = camera;
    const Camera view{to_vec3(eye, "eye"), to_vec3(target, "target"), to_vec3(up, "up"), fov};
    const SplatOptions options{to_vec3(background, "background"), footprint, samples, to_vector(objects)};
    const SplatImage image =
        without_gil([&] { return splat_image(surfels, colors, lamps, view, width, height, options); });
    py::dict out;
    out["radiance"] = pixels(image.radiance, image, 3);
    out["coverage"] = pixels(image.coverage, image, 1);
    out["depth"] = pixels(image.depth, image, 1);
    out["normal"] = pixels(image.normal, image, 3);
    out["index"] = pixels(image.index, image, 1);
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
