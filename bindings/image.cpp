#include "convert.h"

#include "surflux/core/file_bytes.h"
#include "surflux/image/image.h"

namespace surflux::bindings {

namespace {

py::tuple read(const std::string& path) {
    const Image image = without_gil([&] { return read_image(path); });
    py::array_t<float> pixels({static_cast<py::ssize_t>(image.height), static_cast<py::ssize_t>(image.width),
                               static_cast<py::ssize_t>(image.channels.size())});
    std::memcpy(pixels.mutable_data(), image.pixels.data(), image.pixels.size() * sizeof(float));
    return py::make_tuple(image.channels, pixels);
}

void write(const std::string& path, const std::vector<std::string>& names, const Floats& pixels) {
    require(pixels.ndim() == 3 && pixels.shape(2) == static_cast<py::ssize_t>(names.size()),
            "image: wanted shape (h, w, ", names.size(), ")");
    const Image image{static_cast<std::size_t>(pixels.shape(1)), static_cast<std::size_t>(pixels.shape(0)), names,
                      to_vector(pixels)};
    py::gil_scoped_release release;
    write_image(path, image);
}

}  // namespace

// A module of its own, loaded with the first picture: OpenImageIO of a distribution brings some 250 libraries along.
PYBIND11_MODULE(_image, module) {
    module.doc() = "Picture files. Use surflux.read_image and write_image, which check what they hand in here.";
    static const py::handle file_error = py::object(py::module_::import("surflux._core").attr("FileError")).release();
    py::register_local_exception_translator([](std::exception_ptr thrown) {
        try {
            if (thrown) std::rethrow_exception(thrown);
        } catch (const FileError& error) {
            py::set_error(file_error, shown_path(error.what()).c_str());  // Python wants UTF-8
        }
    });
    module.def("read_image", &read, py::arg("path"));
    module.def("write_image", &write, py::arg("path"), py::arg("names"), py::arg("pixels"));
    module.def("version", &image_library_version);
}

}  // namespace surflux::bindings
