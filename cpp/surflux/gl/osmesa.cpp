// OSMesa, Mesa's software rasterizer without any window system: the last resort. Its header includes GL/gl.h, which
// does not go together with GL/glcorearb.h, so the few names that we need stand here.

#include <array>

#include "surflux/core/error.h"
#include "surflux/gl/platforms.h"

namespace surflux::gl {

namespace {

constexpr int osmesa_format = 0x22, osmesa_rgba = 0x1908, osmesa_profile = 0x33, osmesa_core_profile = 0x34;
constexpr int osmesa_major_version = 0x36, osmesa_minor_version = 0x37;

struct OsMesa {
    using ContextHandle = struct osmesa_context*;
    using Procedure = void (*)();
    ContextHandle (*create_context)(const int* attributes, ContextHandle share) = nullptr;
    GLboolean (*make_current)(ContextHandle, void* buffer, GLenum type, GLsizei width, GLsizei height) = nullptr;
    void (*destroy_context)(ContextHandle) = nullptr;
    Procedure (*get_proc_address)(const char*) = nullptr;

    OsMesa() {
        void* library = open_library("libOSMesa.so.8");
        load(library, "OSMesaCreateContextAttribs", create_context);
        load(library, "OSMesaMakeCurrent", make_current);
        load(library, "OSMesaDestroyContext", destroy_context);
        load(library, "OSMesaGetProcAddress", get_proc_address);
    }
};

class OsMesaPlatform : public Platform {
public:
    explicit OsMesaPlatform(const OsMesa& osmesa) : osmesa_(osmesa) {
        const int attributes[] = {osmesa_format,        osmesa_rgba,          osmesa_profile,
                                  osmesa_core_profile,  osmesa_major_version, required_major,
                                  osmesa_minor_version, required_minor,       0};
        context_ = osmesa.create_context(attributes, nullptr);
        if (!context_) {
            throw DeviceError(message("it gives no OpenGL ", required_major, ".", required_minor, " core context"));
        }
        if (!osmesa.make_current(context_, pixel_.data(), GL_FLOAT, 1, 1)) {
            osmesa.destroy_context(context_);
            throw DeviceError("OSMesaMakeCurrent failed");
        }
    }

    ~OsMesaPlatform() override {
        osmesa_.make_current(nullptr, nullptr, GL_FLOAT, 0, 0);
        osmesa_.destroy_context(context_);
    }

    void (*function(const char* name) const)() override { return osmesa_.get_proc_address(name); }

private:
    OsMesa osmesa_;
    OsMesa::ContextHandle context_ = nullptr;
    std::array<float, 4> pixel_{};  // the window that OSMesa insists on; our passes draw into framebuffers
};

}  // namespace

std::vector<Candidate> osmesa_candidates() {
    return {{"OSMesa", [osmesa = OsMesa()] { return std::make_unique<OsMesaPlatform>(osmesa); }}};
}

}  // namespace surflux::gl
