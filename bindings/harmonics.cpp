#include "convert.h"
#include "rooms.h"

#include "surflux/transfer/harmonic_lobe.h"
#include "surflux/transfer/harmonic_product.h"
#include "surflux/transfer/harmonic_projection.h"
#include "surflux/transfer/harmonic_rotation.h"
#include "surflux/transfer/spherical_harmonics.h"

namespace surflux::bindings {

namespace {

// Coefficients (order^2, channels).
struct Coefficients {
    explicit Coefficients(const Doubles& array) : values(array) {
        require(array.ndim() == 2, "coefficients: wanted shape (n, channels)");
        order = SphericalHarmonics::order_of(static_cast<std::size_t>(array.shape(0)), "coefficients");
        channels = static_cast<int>(array.shape(1));
    }
    py::array_t<double> like() const { return py::array_t<double>({values.shape(0), values.shape(1)}); }
    Doubles values;
    int order, channels;
};

py::array_t<double> harmonics_in(const Doubles& directions, int order) {
    const std::vector<Vec3> in = to_vec3s(directions, "directions");
    const std::vector<double> values = without_gil([&] { return spherical_harmonics(in, order); });
    py::array_t<double> out({in.size(), SphericalHarmonics::count(order)});
    std::copy(values.begin(), values.end(), out.mutable_data());
    return out;
}

py::array_t<double> rotated(const Doubles& coefficients, const Doubles& rotation) {
    const Coefficients in(coefficients);
    const std::vector<Vec3> rows = to_vec3s(rotation, "rotation");
    require(rows.size() == 3, "rotation: wanted shape (3, 3)");
    py::array_t<double> out = in.like();
    HarmonicRotation({rows[0], rows[1], rows[2]}, in.order).apply(in.values.data(), out.mutable_data(), in.channels);
    return out;
}

py::array_t<double> convolved(const Doubles& coefficients, double exponent) {
    const Coefficients in(coefficients);
    py::array_t<double> out = in.like();
    std::copy_n(in.values.data(), in.values.size(), out.mutable_data());
    scale_bands(lobe_bands(exponent, in.order), out.mutable_data(), in.channels);
    return out;
}

// Of n functions each, (n, order^2), row by row.
py::array_t<double> multiplied(const Doubles& a, const Doubles& b, int order) {
    require(a.ndim() == 2 && b.ndim() == 2 && a.shape(0) == b.shape(0), "b: wanted as many functions as a");
    const int order_a = SphericalHarmonics::order_of(static_cast<std::size_t>(a.shape(1)), "a");
    const int order_b = SphericalHarmonics::order_of(static_cast<std::size_t>(b.shape(1)), "b");
    const HarmonicProduct product(order_a, order_b, order);
    py::array_t<double> out({static_cast<std::size_t>(a.shape(0)), SphericalHarmonics::count(order)});
    for (py::ssize_t i = 0; i < a.shape(0); ++i) product.multiply(a.data(i, 0), b.data(i, 0), out.mutable_data(i, 0));
    return out;
}

py::array_t<double> projected(const Environment& environment, int order) {
    return to_array(without_gil([&] { return project_environment(environment, order); }));
}

py::array_t<double> image_of(const Doubles& coefficients, std::size_t width, std::size_t height) {
    const std::vector<Vec3> in = to_vec3s(coefficients, "coefficients");
    const Environment image = without_gil([&] { return environment_of_harmonics(in, width, height); });
    py::array_t<double> out({height, width, std::size_t{3}});
    std::memcpy(out.mutable_data(), image.pixels.data(), image.pixels.size() * sizeof(Rgb));
    return out;
}

}  // namespace

void bind_harmonics(py::module_& module) {
    module.attr("largest_harmonic_order") = int{SphericalHarmonics::largest_order};
    module.def("spherical_harmonics", &harmonics_in, py::arg("directions"), py::arg("order"));
    module.def("rotate_harmonics", &rotated, py::arg("coefficients"), py::arg("rotation"));
    module.def("convolve_harmonics", &convolved, py::arg("coefficients"), py::arg("exponent"));
    module.def("multiply_harmonics", &multiplied, py::arg("a"), py::arg("b"), py::arg("order"));
    module.def("project_environment", &projected, py::arg("environment"), py::arg("order"));
    module.def("image_of_harmonics", &image_of, py::arg("coefficients"), py::arg("width"), py::arg("height"));
}

}  // namespace surflux::bindings
