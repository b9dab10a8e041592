#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "surflux/core/error.h"

namespace surflux::fuzz {

// A reader may take the bytes or refuse them with a FileError that begins with the path; all else is a fault. (Any
// other exception ends the program, as a crash, a hang, a leak or too much memory does.)
inline void hold(bool condition, const char* what) {
    if (condition) return;
    std::fprintf(stderr, "fuzz: broken promise: %s\n", what);
    std::abort();
}

template <class Read>
void accepted_or_refused(const std::string& path, const Read& read) {
    try {
        read();
    } catch (const FileError& error) {
        const std::string text = error.what();
        hold(text.rfind(path, 0) == 0, "an error names the file first");
        hold(text.size() > path.size() + 2, "an error has a reason");
    }
}

}  // namespace surflux::fuzz

// What libFuzzer calls, once per run.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
