#include "convert.h"
#include "pictures.h"
#include "rooms.h"

#include "surflux/core/parallel.h"
#include "surflux/gl/context.h"
#include "surflux/render/environment_image.h"
#include "surflux/render/flat_image.h"
#include "surflux/render/mip_map.h"
#include "surflux/render/seen_places.h"
#include "surflux/render/splat.h"

namespace surflux::bindings {

namespace {

using Layer = std::tuple<Doubles, bool>;  // values, are emitters lit?

py::dict render_splats(const Surfels& surfels, const std::vector<Layer>& layers,
                       const std::vector<EmitterArrays>& emitters, const CameraArrays& camera, std::size_t width,
                       std::size_t height, double footprint, int samples, bool culling,
                       const py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>& objects,
                       const py::object& progress, std::size_t top, std::size_t rows, const KernelWalls* walls) {
    std::vector<SplatLayer> blended;
    for (const auto& [values, lit] : layers) blended.push_back({to_vec3s(values, "values"), lit});
    const std::vector<VisibleEmitter> lamps = to_emitters(emitters);
    const Camera view = to_camera(camera);
    const SplatOptions options{footprint, samples, culling, to_vector(objects), walls, {top, rows}};
    const Progress report = to_progress(progress);
    const SplatImage image =
        without_gil([&] { return splat_image(surfels, blended, lamps, view, width, height, options, report); });
    py::list pictures;
    for (const std::vector<float>& layer : image.layers) pictures.append(to_pixels(layer, image.height, width, 3));
    py::dict out;
    out["layers"] = pictures;
    out["coverage"] = to_pixels(image.coverage, image.height, width, 1);
    out["depth"] = to_pixels(image.depth, image.height, width, 1);
    out["normal"] = to_pixels(image.normal, image.height, width, 3);
    out["index"] = to_pixels(image.index, image.height, width, 1);
    return out;
}

// (h, w, 3): what pixels see, of the rows that depths and indices have.
py::array seen_places_of(const Surfels& surfels, const CameraArrays& camera, std::size_t width, std::size_t height,
                         std::size_t top, const Floats& depths,
                         const py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>& indices) {
    const std::vector<float> far(depths.data(), depths.data() + depths.size());
    const std::vector<std::int32_t> seen(indices.data(), indices.data() + indices.size());
    const Camera view = to_camera(camera);
    const std::vector<Vec3> places =
        without_gil([&] { return seen_places(surfels, view, width, height, top, far, seen); });
    return to_array(places).attr("reshape")(far.size() / width, width, 3);
}

FlatImage make_flat_image(const Surfels& surfels, const std::vector<EmitterArrays>& emitters,
                          const CameraArrays& camera, std::size_t width, std::size_t height, double footprint,
                          int samples, bool culling,
                          const py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>& objects,
                          const KernelWalls* walls) {
    const std::vector<VisibleEmitter> lamps = to_emitters(emitters);
    const Camera view = to_camera(camera);
    const SplatOptions options{footprint, samples, culling, to_vector(objects), walls, {}};
    return without_gil([&] { return flat_image(surfels, lamps, view, width, height, options); });
}

py::array draw_flat(const FlatImage& image, const Doubles& values, const Doubles& emitters) {
    const std::vector<Rgb> of_surfels = to_vec3s(values, "values"), of_emitters = to_vec3s(emitters, "emitters");
    const std::vector<float> picture = without_gil([&] { return image.draw(of_surfels, of_emitters); });
    return to_pixels(picture, image.height(), image.width(), 3);
}

MipMap make_mip_map(const Floats& texels) {
    require(texels.ndim() == 3, "texels: wanted shape (h, w, c)");
    const auto size = [&](int axis) { return static_cast<std::size_t>(texels.shape(axis)); };
    std::vector<float> values = to_vector(texels);
    return without_gil([&] { return MipMap(std::move(values), size(1), size(0), size(2)); });
}

// (n, channels): means around places (n, 2) over parallelograms of sides (n, 2, 2); all finite.
py::array means_of_texels(const MipMap& texture, const Doubles& places, const Doubles& sides) {
    const auto n = static_cast<std::size_t>(places.size() / 2), channels = texture.channels();
    require(places.size() % 2 == 0 && sides.size() == 2 * places.size(), "sides: wanted two for each place");
    const double *at = places.data(), *by = sides.data();
    std::vector<double> out(n * channels);
    without_gil([&] {
        parallel_for(n, 1024, [&](std::size_t k) {
            const double *place = at + 2 * k, *side = by + 4 * k;
            texture.mean({place[0], place[1]}, {side[0], side[1]}, {side[2], side[3]}, &out[k * channels]);
        });
    });
    return to_pixels(out, n, channels, 1);
}

// (height, width, 3): what Environments add to a picture, by what it covers.
py::array draw_environments(const std::vector<Light>& environments, const CameraArrays& camera, const Floats& coverage,
                            int samples) {
    require(coverage.ndim() == 2, "coverage: wanted shape (h, w)");
    const auto height = static_cast<std::size_t>(coverage.shape(0)),
               width = static_cast<std::size_t>(coverage.shape(1));
    const Camera view = to_camera(camera);
    const std::vector<float> covered = to_vector(coverage);
    const std::vector<float> image =
        without_gil([&] { return environment_image(environments, view, width, height, samples, covered); });
    return to_pixels(image, height, width, 3);
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
    py::class_<KernelWalls>(module, "KernelWalls")
        .def(py::init([](const Surfels& surfels, double footprint, const py::object& progress) {
                 const Progress report = to_progress(progress);
                 return without_gil([&] { return std::make_unique<KernelWalls>(surfels, footprint, report); });
             }),
             py::arg("surfels"), py::arg("footprint"), py::arg("progress") = py::none())
        .def("__len__", &KernelWalls::size);
    module.def("render_splats", &render_splats, py::arg("surfels"), py::arg("layers"), py::arg("emitters"),
               py::arg("camera"), py::arg("width"), py::arg("height"), py::arg("footprint"), py::arg("samples"),
               py::arg("culling") = true, py::arg("objects") = py::array_t<std::int32_t>(0),
               py::arg("progress") = py::none(), py::arg("top") = 0, py::arg("rows") = static_cast<std::size_t>(-1),
               py::arg("walls") = py::none());
    module.def("seen_places", &seen_places_of, py::arg("surfels"), py::arg("camera"), py::arg("width"),
               py::arg("height"), py::arg("top"), py::arg("depths"), py::arg("indices"));
    py::class_<FlatImage>(module, "FlatImage")
        .def(py::init(&make_flat_image), py::arg("surfels"), py::arg("emitters"), py::arg("camera"), py::arg("width"),
             py::arg("height"), py::arg("footprint"), py::arg("samples"), py::arg("culling") = true,
             py::arg("objects") = py::array_t<std::int32_t>(0), py::arg("walls") = py::none())
        .def_property_readonly("entries", &FlatImage::entries)
        .def_property_readonly("bytes", &FlatImage::bytes)
        .def_property_readonly(
            "coverage",
            [](const FlatImage& image) { return to_pixels(image.coverage(), image.height(), image.width(), 1); })
        .def("draw", &draw_flat, py::arg("values"), py::arg("emitters"));
    py::class_<MipMap>(module, "MipMap")
        .def(py::init(&make_mip_map), py::arg("texels"))
        .def_property_readonly("bytes", &MipMap::bytes)
        .def("means", &means_of_texels, py::arg("places"), py::arg("sides"));
    module.def("environment_image", &draw_environments, py::arg("environments"), py::arg("camera"), py::arg("coverage"),
               py::arg("samples"));
    module.def("gl_info", &gl_info);
}

}  // namespace surflux::bindings
