#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "surflux/files/ply.h"

namespace surflux {

enum class PlyFormat { ascii, little_endian, big_endian };

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::float32;
    bool is_list = false;
    PlyType count_type = PlyType::uint8;
};

struct PlyHeader {
    struct Element {
        std::string name;
        std::size_t count = 0;
        std::vector<PlyProperty> properties;
    };

    PlyFormat format = PlyFormat::ascii;
    std::vector<Element> elements;
    std::vector<std::string> comments;
    std::vector<std::string> object_info;
    std::size_t body = 0;       // byte offset of what follows end_header
    std::size_t body_line = 0;  // and its line number, from 1
    char newline = '\n';        // '\r' where the header's lines end in it alone
};

// `path` is for messages. Throws FileError with the line.
PlyHeader parse_ply_header(const std::string& path, std::string_view bytes);

}  // namespace surflux
