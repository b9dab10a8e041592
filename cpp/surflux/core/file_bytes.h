#pragma once

#include <string>
#include <string_view>

namespace surflux {

// The whole of a regular file. Throws FileError.
std::string read_bytes(const std::string& path);

// Refuses a path to write to whose folder is not there, or that is one itself. Throws FileError.
void require_folder(const std::string& path);

// Replaces `path` by these bytes at once: a reader sees the old file or the new one, never a part. Throws FileError.
void write_bytes(const std::string& path, std::string_view bytes);

// Text from a file as it may stand in a message: short, plain ASCII, in quotes.
std::string quoted(std::string_view text);

// A path as it may stand in a message: bytes that are not UTF-8 are escaped.
std::string shown_path(const std::string& path);

}  // namespace surflux
