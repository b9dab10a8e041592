#pragma once

#include <cmath>

#include "surflux/core/error.h"
#include "surflux/core/sampling.h"
#include "surflux/core/vec.h"

namespace surflux {

// A pinhole camera, or a parallel projection. Row 0 of its images is on top; depth is measured along the view axis, not
// along the ray.
struct Camera {
    Vec3 eye, target;
    Vec3 up{0, 0, 1};
    double fov = 45.0;    // vertical, full angle in degrees
    double height = 0.0;  // of what an orthographic camera shows, in the unit of positions; 0: a pinhole camera
};

// The camera's axes, orthonormal: right and down in the image, forward along the view axis.
struct CameraFrame {
    Vec3 eye, right, down, forward;
    double tan_half = 0.0;  // of the vertical field of view; of a parallel projection half its height
    bool parallel = false;

    // World -> (right, down, depth).
    Vec3 to_camera(const Vec3& point) const { return turn(point - eye); }
    Vec3 turn(const Vec3& v) const { return {dot(v, right), dot(v, down), dot(v, forward)}; }
    Vec3 turn_back(const Vec3& v) const { return v.x * right + v.y * down + v.z * forward; }
};

// Throws ArgumentError, naming the argument, for a camera that looks nowhere.
inline CameraFrame frame_of(const Camera& camera) {
    require(is_finite(camera.eye), "eye: wanted finite numbers");
    require(is_finite(camera.target), "target: wanted finite numbers");
    require(is_finite(camera.up), "up: wanted finite numbers");
    require(camera.fov > 0.0 && camera.fov < 180.0, "fov: wanted degrees between 0 and 180, got ", camera.fov);
    require(std::isfinite(camera.height) && camera.height >= 0.0, "height: wanted a length above 0, got ",
            camera.height);
    const Vec3 view = camera.target - camera.eye;
    require(length(view) > 0.0, "target: wanted a point other than the eye");
    require(length(camera.up) > 0.0, "up: wanted a direction, got zero");
    CameraFrame frame;
    frame.eye = camera.eye;
    frame.forward = normalized(view);
    const Vec3 right = cross(frame.forward, normalized(camera.up));
    require(length(right) > 1e-6, "up: wanted a direction not parallel to the view");
    frame.right = normalized(right);
    frame.down = cross(frame.forward, frame.right);
    frame.parallel = camera.height > 0.0;
    frame.tan_half = frame.parallel ? 0.5 * camera.height : std::tan(camera.fov * pi / 360.0);
    return frame;
}

}  // namespace surflux
