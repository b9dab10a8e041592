#include "convert.h"
#include "rooms.h"

#include "surflux/core/srgb.h"
#include "surflux/render/tone_map.h"

namespace surflux::bindings {

namespace {

// The same array, its values through `curve`.
template <class Curve>
py::array_t<float> mapped(const Floats& values, const Curve& curve) {
    std::vector<float> in = to_vector(values), out;
    {
        py::gil_scoped_release release;
        out = curve(std::move(in));
    }
    py::array_t<float> result(std::vector<py::ssize_t>(values.shape(), values.shape() + values.ndim()));
    std::memcpy(result.mutable_data(), out.data(), out.size() * sizeof(float));
    return result;
}

// An array of any shape, each value through a transfer function.
py::array_t<double> each(const Doubles& values, double (*curve)(double)) {
    py::array_t<double> result(std::vector<py::ssize_t>(values.shape(), values.shape() + values.ndim()));
    const double* in = values.data();
    double* out = result.mutable_data();
    const py::ssize_t count = values.size();
    {
        py::gil_scoped_release release;
        for (py::ssize_t i = 0; i < count; ++i) out[i] = curve(in[i]);
    }
    return result;
}

}  // namespace

void bind_tone_map(py::module_& module) {
    module.def(
        "tone_map",
        [](const Floats& rgb, const std::optional<double>& exposure, bool filmic) {
            return mapped(rgb, [&](std::vector<float> in) { return tone_map(in, {exposure, filmic}); });
        },
        py::arg("rgb"), py::arg("exposure"), py::arg("filmic"));
    module.def("automatic_exposure", [](const Floats& rgb) {
        const std::vector<float> in = to_vector(rgb);
        return without_gil([&] { return automatic_exposure(in); });
    });
    module.def("srgb_encode", [](const Doubles& linear) { return each(linear, srgb_encode); });
    module.def("srgb_decode", [](const Doubles& encoded) { return each(encoded, srgb_decode); });
}

}  // namespace surflux::bindings
