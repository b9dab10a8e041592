#include "arrays.h"
#include "convert.h"
#include "pictures.h"
#include "rooms.h"
#include "solution_dict.h"

#include "surflux/render/lamp_view.h"

namespace surflux::bindings {

namespace {

std::unique_ptr<PatchCorners> make_corners(const LocalTransfer& transfer, const py::object& progress) {
    const Progress report = to_progress(progress);
    return without_gil([&] {
        const CompiledScene& scene = transfer.scene();
        return std::make_unique<PatchCorners>(
            patch_corners(scene.scene(), scene.tracer(), transfer.transport().areas, report));
    });
}

std::unique_ptr<LampView> make_view(const LocalTransfer& transfer, const PatchCorners& corners,
                                    const CameraArrays& camera, std::size_t width, std::size_t height, int samples,
                                    bool culling, std::size_t shadow_cell) {
    const Camera from = to_camera(camera);
    return without_gil([&] {
        return std::make_unique<LampView>(transfer, corners, from, width, height,
                                          LampViewOptions{samples, culling, shadow_cell});
    });
}

std::vector<Rgb> to_reflectance(const py::object& reflectance) {
    return reflectance.is_none() ? std::vector<Rgb>() : to_vec3s(reflectance.cast<Doubles>(), "reflectance");
}

// Pictures by name, and "shadow_rays" and "timings".
py::dict frame(const LampView& view, const std::vector<Light>& lights, const py::object& reflectance, int bounces,
               std::size_t relight_rays, int penumbra_rays, bool parts, std::uint64_t seed) {
    const std::vector<Rgb> own = to_reflectance(reflectance);
    const LampFrameOptions options{{bounces, relight_rays, seed}, {penumbra_rays, seed}, parts};
    LampFrame found = without_gil([&] { return view.frame(lights, own, options); });
    const auto height = static_cast<py::ssize_t>(view.height()), width = static_cast<py::ssize_t>(view.width());
    const auto picture = [&](std::vector<float>&& pixels) {
        return handed_over(std::move(pixels)).reshape({height, width, py::ssize_t{3}});
    };
    py::dict out;
    out["radiance"] = picture(std::move(found.radiance));
    if (parts) {
        out["direct"] = picture(std::move(found.direct));
        out["indirect"] = picture(std::move(found.indirect));
    }
    out["alpha"] = handed_over(std::move(found.coverage)).reshape({height, width});
    out["shadow_rays"] = found.shadow_rays;
    out["timings"] = to_dict(found.timings);
    return out;
}

py::dict surfaces(const LampView& view, const std::vector<Light>& lights, const py::object& reflectance) {
    const std::vector<Rgb> own = to_reflectance(reflectance);
    const LampSurfaces found = without_gil([&] { return view.surfaces(lights, own); });
    py::dict out;
    out["albedo"] = to_pixels(found.albedo, view.height(), view.width(), 3);
    out["normal"] = to_pixels(found.normal, view.height(), view.width(), 3);
    out["depth"] = to_pixels(found.depth, view.height(), view.width(), 1);
    out["index"] = to_pixels(found.index, view.height(), view.width(), 1);
    return out;
}

}  // namespace

void bind_lamp_view(py::module_& module) {
    py::class_<PatchCorners>(module, "PatchCorners")
        .def(py::init(&make_corners), py::arg("transfer"), py::arg("progress") = py::none());
    py::class_<LampView>(module, "LampView")
        .def(py::init(&make_view), py::arg("transfer"), py::arg("corners"), py::arg("camera"), py::arg("width"),
             py::arg("height"), py::arg("samples"), py::arg("culling"), py::arg("shadow_cell"), py::keep_alive<1, 2>())
        .def("frame", &frame, py::arg("lights"), py::arg("reflectance"), py::arg("bounces"), py::arg("relight_rays"),
             py::arg("penumbra_rays"), py::arg("parts"), py::arg("seed"))
        .def("surfaces", &surfaces, py::arg("lights"), py::arg("reflectance"))
        .def_property_readonly("bytes", &LampView::bytes)
        .def_property_readonly("timings", [](const LampView& view) { return to_dict(view.timings()); });
}

}  // namespace surflux::bindings
