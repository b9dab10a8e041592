#pragma once

// Plain data as numpy arrays by name, and back: what files keep.

#include "convert.h"

namespace surflux::bindings {

// The memory of a vector as an array that nobody may write to; `owner` stays alive as long as it.
template <class T>
py::array view_of(const std::vector<T>& values, const py::object& owner) {
    const auto n = static_cast<py::ssize_t>(values.size());
    py::array out;
    if constexpr (std::is_same_v<T, Vec3>)
        out = py::array_t<double>({n, py::ssize_t{3}}, reinterpret_cast<const double*>(values.data()), owner);
    else
        out = py::array_t<T>(n, values.data(), owner);
    out.attr("setflags")(py::arg("write") = false);
    return out;
}

// A vector from the array of that name, (n,) or of Vec3 (n, 3). Throws ArgumentError where it is missing or of another
// type; what is in it is for others to check.
template <class T>
void take(const py::dict& arrays, const char* name, std::vector<T>& out) {
    constexpr bool is_vec3 = std::is_same_v<T, Vec3>;
    using Array = py::array_t<std::conditional_t<is_vec3, double, T>, py::array::c_style>;
    require(arrays.contains(name), name, ": is missing");
    const py::object given = arrays[name];
    require(Array::check_(given), name, ": holds other numbers than it should");
    const auto array = py::reinterpret_borrow<Array>(given);
    require(is_vec3 ? array.ndim() == 2 && array.shape(1) == 3 : array.ndim() == 1, name, ": has another shape");
    out.resize(static_cast<std::size_t>(array.shape(0)));
    if (!out.empty()) std::memcpy(static_cast<void*>(out.data()), array.data(), out.size() * sizeof(T));
}

}  // namespace surflux::bindings
