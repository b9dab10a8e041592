#pragma once

#include <memory>
#include <string>
#include <vector>

#include "surflux/gl/context.h"

namespace surflux::gl {

// The ways to a context that a library offers, in the order to try them.
struct Candidate {
    std::string name;
    // Makes a core context of at least `major.minor` and makes it current, or throws DeviceError with the reason.
    std::function<std::unique_ptr<Platform>()> make;
};

// Each throws DeviceError where the library itself cannot be opened.
std::vector<Candidate> egl_candidates();
std::vector<Candidate> osmesa_candidates();

constexpr int required_major = 4, required_minor = 3;

// dlopen, never closed: Mesa does not survive being unloaded. Throws DeviceError.
void* open_library(const char* name);
// dlsym that throws DeviceError.
void* find_symbol(void* library, const char* name);

template <class Function>
void load(void* library, const char* name, Function& function) {
    function = reinterpret_cast<Function>(find_symbol(library, name));
}

}  // namespace surflux::gl
