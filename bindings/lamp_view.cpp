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

// "index" (-1 where nothing is), "depth" and "position" of subpixels.
py::dict seen(const LampView& view) {
    const PixelPlaces& places = view.places();
    const std::size_t width = places.rays.width, height = places.rays.height;
    std::vector<std::int32_t> index(places.size(), -1);
    std::vector<Vec3> positions(places.size());
    for (std::size_t p = 0; p < places.size(); ++p)
        if (places.is_seen(p)) index[p] = static_cast<std::int32_t>(places.surfel[p]), positions[p] = places.place(p);
    py::dict out;
    out["index"] = to_pixels(index, height, width, 1);
    out["depth"] = to_pixels(places.depth, height, width, 1);
    out["position"] = to_array(positions).attr("reshape")(height, width, 3);
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
        .def("seen", &seen)
        .def(
            "paint",
            [](LampView& view, const py::array_t<char, py::array::c_style | py::array::forcecast>& painted,
               const Floats& reflectance,
               const Floats& emission) { view.paint(to_vector(painted), to_vector(reflectance), to_vector(emission)); },
            py::arg("painted"), py::arg("reflectance"), py::arg("emission"))
        .def("surfaces", &surfaces, py::arg("lights"), py::arg("reflectance"))
        .def_property_readonly("bytes", &LampView::bytes)
        .def_property_readonly("timings", [](const LampView& view) { return to_dict(view.timings()); });
}

}  // namespace surflux::bindings
