// EGL without windows: its devices one by one, then its surfaceless platform. No display is ever terminated: others in
// the process may share it, and Mesa unloaded turns its leaks into ones that no suppression of LeakSanitizer matches.

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "surflux/core/error.h"
#include "surflux/gl/platforms.h"

namespace surflux::gl {

namespace {

struct Egl {
    PFNEGLGETPROCADDRESSPROC get_proc_address = nullptr;
    PFNEGLGETERRORPROC get_error = nullptr;
    PFNEGLQUERYSTRINGPROC query_string = nullptr;
    PFNEGLINITIALIZEPROC initialize = nullptr;
    PFNEGLBINDAPIPROC bind_api = nullptr;
    PFNEGLCHOOSECONFIGPROC choose_config = nullptr;
    PFNEGLCREATECONTEXTPROC create_context = nullptr;
    PFNEGLDESTROYCONTEXTPROC destroy_context = nullptr;
    PFNEGLMAKECURRENTPROC make_current = nullptr;
    PFNEGLRELEASETHREADPROC release_thread = nullptr;
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display = nullptr;  // an extension, like those below: may be null
    PFNEGLQUERYDEVICESEXTPROC query_devices = nullptr;

    Egl() {
        void* library = open_library("libEGL.so.1");
        load(library, "eglGetProcAddress", get_proc_address);
        load(library, "eglGetError", get_error);
        load(library, "eglQueryString", query_string);
        load(library, "eglInitialize", initialize);
        load(library, "eglBindAPI", bind_api);
        load(library, "eglChooseConfig", choose_config);
        load(library, "eglCreateContext", create_context);
        load(library, "eglDestroyContext", destroy_context);
        load(library, "eglMakeCurrent", make_current);
        load(library, "eglReleaseThread", release_thread);
        get_platform_display =
            reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(get_proc_address("eglGetPlatformDisplayEXT"));
        query_devices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(get_proc_address("eglQueryDevicesEXT"));
        if (!get_platform_display) throw DeviceError("no eglGetPlatformDisplayEXT");
    }

    [[noreturn]] void fail(const char* function) const {
        throw DeviceError(message(function, " failed with EGL error 0x", std::hex, get_error()));
    }
};

class EglPlatform : public Platform {
public:
    EglPlatform(const Egl& egl, EGLenum platform, void* device) : egl_(egl) {
        display_ = egl.get_platform_display(platform, device, nullptr);
        if (display_ == EGL_NO_DISPLAY) egl.fail("eglGetPlatformDisplayEXT");
        if (!egl.initialize(display_, nullptr, nullptr)) egl.fail("eglInitialize");
        if (!egl.bind_api(EGL_OPENGL_API)) egl.fail("eglBindAPI");
        const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_NONE};
        EGLConfig config = nullptr;
        EGLint count = 0;
        if (!egl.choose_config(display_, wanted, &config, 1, &count)) egl.fail("eglChooseConfig");
        if (count == 0) throw DeviceError("no configuration for OpenGL");
        const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                     required_major,
                                     EGL_CONTEXT_MINOR_VERSION,
                                     required_minor,
                                     EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                     EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                     EGL_NONE};
        context_ = egl.create_context(display_, config, EGL_NO_CONTEXT, attributes);
        if (context_ == EGL_NO_CONTEXT) egl.fail("eglCreateContext");
        if (!egl.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_)) {
            egl.destroy_context(display_, context_);
            egl.fail("eglMakeCurrent");
        }
    }

    ~EglPlatform() override {
        egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        egl_.destroy_context(display_, context_);
        egl_.release_thread();
    }

    void (*function(const char* name) const)() override { return egl_.get_proc_address(name); }

private:
    Egl egl_;
    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

std::vector<Candidate> egl_candidates() {
    const Egl egl;
    std::vector<Candidate> candidates;
    EGLint count = 0;
    if (egl.query_devices && egl.query_devices(0, nullptr, &count)) {
        std::vector<EGLDeviceEXT> devices(static_cast<std::size_t>(count));
        if (!egl.query_devices(count, devices.data(), &count)) count = 0;
        for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
            candidates.push_back({message("EGL device ", i), [egl, device = devices[i]] {
                                      return std::make_unique<EglPlatform>(egl, EGL_PLATFORM_DEVICE_EXT, device);
                                  }});
        }
    }
    candidates.push_back({"EGL surfaceless", [egl] {
                              return std::make_unique<EglPlatform>(egl, EGL_PLATFORM_SURFACELESS_MESA,
                                                                   reinterpret_cast<void*>(EGL_DEFAULT_DISPLAY));
                          }});
    return candidates;
}

}  // namespace surflux::gl
