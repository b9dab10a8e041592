#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace surflux {

// An argument that a pass cannot take. Python sees a ValueError.
struct ArgumentError : std::invalid_argument {
    using std::invalid_argument::invalid_argument;
};

// A file that cannot be read or written: path, place (line or byte offset; may be empty) and reason.
// Python sees surflux.FileError.
struct FileError : std::runtime_error {
    FileError(const std::string& path, const std::string& place, const std::string& reason)
        : std::runtime_error(path + (place.empty() ? "" : " (" + place + ")") + ": " + reason) {}
};

// Something the machine lacks: a GL device, memory. Python sees a RuntimeError.
struct DeviceError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// The caller's progress callback said stop. Python sees surflux.Cancelled.
struct Cancelled : std::runtime_error {
    Cancelled() : std::runtime_error("cancelled by the progress callback") {}
};

// Builds a message from anything that can be streamed.
template <class... Parts>
std::string message(const Parts&... parts) {
    std::ostringstream text;
    (text << ... << parts);
    return text.str();
}

template <class... Parts>
void require(bool condition, const Parts&... parts) {
    if (!condition) throw ArgumentError(message(parts...));
}

}  // namespace surflux
