#pragma once

#include <functional>
#include <memory>
#include <string>

#include "surflux/gl/functions.h"

namespace surflux::gl {

// Which library makes the context. `any` tries EGL's devices in their order, then EGL's surfaceless platform, then
// OSMesa, and takes the first that gives OpenGL >= 4.3 core.
enum class Api { any, egl, osmesa };

// The environment's SURFLUX_GL: "egl", "osmesa", or "any" where it is unset. Throws ArgumentError for another word.
Api requested_api();

struct Description {
    std::string api;  // "EGL device 0", "EGL surfaceless", "OSMesa"
    std::string vendor, renderer, version;
};

// What keeps a context alive and finds its functions; egl.cpp and osmesa.cpp have one each.
class Platform {
public:
    virtual ~Platform() = default;
    virtual void (*function(const char* name) const)() = 0;
};

// A headless OpenGL >= 4.3 core context, current on the thread that made it from its construction to its end, with a
// vertex array bound.
// That thread must have had no context current: run_pass sees to it.
class Context {
public:
    // Throws DeviceError with all that was tried, why each failed, and what to install.
    explicit Context(Api api);

    Functions gl;
    Description description;

private:
    std::unique_ptr<Platform> platform_;
};

// Calls pass(context) on a thread of our own, and waits for it; what the pass throws, this throws. A thread of our own
// because the caller's may have a context current (VTK's, of EGL, GLX or OSMesa), which thus stays current and
// untouched. It is kept with its context and programs for the next pass: making and compiling them takes longer than
// many a pass. Passes at the same time have one each. Throws DeviceError where the pass left a GL error, and in a
// process that was forked after a pass.
void run_pass(const std::function<void(const Context&)>& pass, Api api = requested_api());

// The device that a pass would use now.
Description describe(Api api = requested_api());

// Whether the device is a program on the CPU (llvmpipe, SwiftShader and their like), by its renderer's name.
bool is_software(const Description& device);

// False where no kernel driver offers a GPU, so that a context could only be a software one. Makes no context.
bool has_gpu_driver();

}  // namespace surflux::gl
