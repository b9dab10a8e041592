#pragma once

// What passes that draw take and give: cameras and lamps in, pixels out.

#include <tuple>

#include "convert.h"
#include "surflux/render/camera.h"
#include "surflux/render/visible_emitter.h"

namespace surflux::bindings {

using EmitterArrays = std::tuple<Doubles, Doubles, Doubles, Doubles>;        // corner, u, v, radiance
using CameraArrays = std::tuple<Doubles, Doubles, Doubles, double, double>;  // eye, target, up, fov, height

inline std::vector<VisibleEmitter> to_emitters(const std::vector<EmitterArrays>& emitters) {
    std::vector<VisibleEmitter> out;
    for (const auto& [corner, u, v, value] : emitters) {
        out.push_back(
            {to_vec3(corner, "corner"), to_vec3(u, "edge_u"), to_vec3(v, "edge_v"), to_vec3(value, "radiance")});
    }
    return out;
}

inline Camera to_camera(const CameraArrays& camera) {
    const auto& [eye, target, up, fov, height] = camera;
    return {to_vec3(eye, "eye"), to_vec3(target, "target"), to_vec3(up, "up"), fov, height};
}

// (height, width), or with a third axis where there are channels.
template <class T>
py::array_t<T> to_pixels(const std::vector<T>& values, std::size_t height, std::size_t width, py::ssize_t channels) {
    const auto rows = static_cast<py::ssize_t>(height), columns = static_cast<py::ssize_t>(width);
    py::array_t<T> out(channels == 1 ? std::vector<py::ssize_t>{rows, columns}
                                     : std::vector<py::ssize_t>{rows, columns, channels});
    std::memcpy(out.mutable_data(), values.data(), values.size() * sizeof(T));
    return out;
}

}  // namespace surflux::bindings
