#pragma once

// numpy <-> core. Python has checked shapes and values by the time a call arrives here.

#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "surflux/core/error.h"
#include "surflux/core/progress.h"
#include "surflux/core/vec.h"
#include "surflux/scene/colors.h"

namespace surflux::bindings {

namespace py = pybind11;

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Indices = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;

static_assert(sizeof(Vec3) == 3 * sizeof(double));

inline std::vector<Vec3> to_vec3s(const Doubles& array, const char* name) {
    require(array.ndim() == 2 && array.shape(1) == 3, name, ": wanted shape (n, 3)");
    std::vector<Vec3> out(static_cast<std::size_t>(array.shape(0)));
    if (!out.empty()) std::memcpy(static_cast<void*>(out.data()), array.data(), out.size() * sizeof(Vec3));
    return out;
}

struct PointsAndNormals {
    std::vector<Vec3> points, normals;
};
inline PointsAndNormals to_points_and_normals(const Doubles& points, const Doubles& normals) {
    PointsAndNormals out{to_vec3s(points, "points"), to_vec3s(normals, "normals")};
    require(out.points.size() == out.normals.size(), "normals: wanted one for each point");
    return out;
}

inline Vec3 to_vec3(const Doubles& array, const char* name) {
    require(array.ndim() == 1 && array.shape(0) == 3, name, ": wanted shape (3,)");
    return {array.data()[0], array.data()[1], array.data()[2]};
}

template <class T>
std::vector<T> to_vector(const py::array_t<T, py::array::c_style | py::array::forcecast>& array) {
    return std::vector<T>(array.data(), array.data() + array.size());
}

inline py::array_t<double> to_array(const std::vector<Vec3>& values) {
    py::array_t<double> out({static_cast<py::ssize_t>(values.size()), py::ssize_t{3}});
    if (!values.empty()) std::memcpy(out.mutable_data(), values.data(), values.size() * sizeof(Vec3));
    return out;
}

// An array that keeps the memory of the vector.
template <class T>
py::array handed_over(std::vector<T>&& values) {
    auto* kept = new std::vector<T>(std::move(values));
    const py::capsule owner(kept, [](void* vector) { delete static_cast<std::vector<T>*>(vector); });
    const auto n = static_cast<py::ssize_t>(kept->size());
    if constexpr (std::is_same_v<T, Vec3>)
        return py::array_t<double>({n, py::ssize_t{3}}, reinterpret_cast<const double*>(kept->data()), owner);
    else
        return py::array_t<T>(n, kept->data(), owner);
}

inline py::array_t<double> to_array(const Colors& values) {
    py::array_t<double> out({static_cast<py::ssize_t>(values.size()), py::ssize_t{3}});
    auto* to = reinterpret_cast<Vec3*>(out.mutable_data());
    for (const Rgb& value : values) *to++ = value;
    return out;
}

template <class T>
py::array_t<T> to_array(const std::vector<T>& values) {
    return py::array_t<T>(static_cast<py::ssize_t>(values.size()), values.data());
}

// What work() gives, computed while other Python threads run.
template <class Work>
auto without_gil(const Work& work) {
    const py::gil_scoped_release release;
    return work();
}

// A progress callback for passes that run with the GIL released: takes it back, lets Ctrl-C through, and asks
// callable(*leading, done, total), if there is one. Shared, not copied: copies are made without the GIL.
template <class... Leading>
Progress to_progress(const std::shared_ptr<py::object>& callable, const Leading&... leading) {
    return [callable, leading...](std::size_t done, std::size_t total) {
        py::gil_scoped_acquire gil;
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        if (callable->is_none()) return true;
        // False alone cancels, of Python or numpy: callbacks that answer nothing, or a count, go on.
        py::detail::make_caster<bool> answer;
        return !answer.load((*callable)(leading..., done, total), false) || static_cast<bool>(answer);
    };
}

inline Progress to_progress(const py::object& callable) { return to_progress(std::make_shared<py::object>(callable)); }

}  // namespace surflux::bindings
