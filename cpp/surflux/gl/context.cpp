#include "surflux/gl/context.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include <dlfcn.h>

#include "surflux/core/error.h"
#include "surflux/gl/platforms.h"

namespace surflux::gl {

namespace {

constexpr const char* advice = "On Debian or Ubuntu: sudo apt-get install libegl1 libgl1-mesa-dri";

std::string text_of(const Functions& gl, GLenum name) {
    const auto* text = reinterpret_cast<const char*>(gl.GetString(name));
    return text ? text : "unknown";
}

Functions load_functions(const Platform& platform) {
    Functions gl;
#define SURFLUX_GL_LOAD(type, name)                                  \
    gl.name = reinterpret_cast<type>(platform.function("gl" #name)); \
    if (!gl.name) throw DeviceError("the driver has no function gl" #name);
    SURFLUX_GL_FUNCTIONS(SURFLUX_GL_LOAD)
#undef SURFLUX_GL_LOAD
    return gl;
}

}  // namespace

void* open_library(const char* name) {
    void* library = dlopen(name, RTLD_NOW | RTLD_LOCAL);
    if (!library) throw DeviceError(dlerror());
    return library;
}

void* find_symbol(void* library, const char* name) {
    void* symbol = dlsym(library, name);
    if (!symbol) throw DeviceError(message("the library lacks ", name));
    return symbol;
}

Api requested_api() {
    const char* word = std::getenv("SURFLUX_GL");
    const std::string api = word ? word : "";
    if (api.empty() || api == "any") return Api::any;
    if (api == "egl") return Api::egl;
    if (api == "osmesa") return Api::osmesa;
    throw ArgumentError("SURFLUX_GL: wanted egl, osmesa or any, got '" + api + "'");
}

Context::Context(Api api) {
    std::string tried;
    const auto try_all = [&](const char* library, std::vector<Candidate> (*candidates)()) {
        try {
            for (const Candidate& candidate : candidates()) {
                try {
                    platform_ = candidate.make();
                    gl = load_functions(*platform_);
                    // Core GL draws nothing without one, though no attribute of ours comes from it.
                    GLuint vertex_array = 0;
                    gl.GenVertexArrays(1, &vertex_array);
                    gl.BindVertexArray(vertex_array);
                    description = {candidate.name, text_of(gl, GL_VENDOR), text_of(gl, GL_RENDERER),
                                   text_of(gl, GL_VERSION)};
                    return true;
                } catch (const DeviceError& error) {
                    platform_.reset();
                    tried += message("\n  ", candidate.name, ": ", error.what());
                }
            }
        } catch (const DeviceError& error) {
            tried += message("\n  ", library, ": ", error.what());
        }
        return false;
    };
    if (api != Api::osmesa && try_all("EGL", egl_candidates)) return;
    if (api != Api::egl && try_all("OSMesa", osmesa_candidates)) return;
    throw DeviceError(message("no OpenGL >= ", required_major, ".", required_minor,
                              " core context could be made. Tried:", tried, "\n", advice));
}

bool is_software(const Description& device) {
    std::string name = device.renderer;
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    const auto is_in_name = [&](const char* word) { return name.find(word) != std::string::npos; };
    // "software": Mesa's "Software Rasterizer" and Microsoft's; lavapipe stands behind zink.
    const auto words = {"llvmpipe", "softpipe", "swrast", "software", "swiftshader", "lavapipe", "openswr"};
    return std::any_of(words.begin(), words.end(), is_in_name);
}

bool has_gpu_driver() {
    std::error_code ignored;
    // Mesa's drivers draw through render nodes; NVIDIA's own and Windows' subsystem for Linux have devices of their
    // own.
    for (const char* device : {"/dev/nvidiactl", "/dev/dxg"})
        if (std::filesystem::exists(device, ignored)) return true;
    for (const auto& entry : std::filesystem::directory_iterator("/dev/dri", ignored))
        if (entry.path().filename().string().rfind("renderD", 0) == 0) return true;
    return false;
}

}  // namespace surflux::gl
