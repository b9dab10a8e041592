#include <algorithm>
#include <cstring>
#include <string>

#include "surflux/core/error.h"
#include "surflux/core/file_bytes.h"
#include "surflux/files/ply.h"

namespace surflux {

namespace {

// Least significant byte first, on any machine.
template <class T>
void store(char* to, T value) {
    std::memcpy(to, &value, sizeof(T));
    const std::uint16_t one = 1;
    char first;
    std::memcpy(&first, &one, 1);
    if (first != 1) std::reverse(to, to + sizeof(T));
}

void store(char* to, PlyType type, double value) {
    switch (type) {
        case PlyType::int8:
            return store(to, static_cast<std::int8_t>(value));
        case PlyType::uint8:
            return store(to, static_cast<std::uint8_t>(value));
        case PlyType::int16:
            return store(to, static_cast<std::int16_t>(value));
        case PlyType::uint16:
            return store(to, static_cast<std::uint16_t>(value));
        case PlyType::int32:
            return store(to, static_cast<std::int32_t>(value));
        case PlyType::uint32:
            return store(to, static_cast<std::uint32_t>(value));
        case PlyType::float32:
            return store(to, static_cast<float>(value));
        case PlyType::float64:
            return store(to, value);
    }
}

void require_one_word(const char* what, const std::string& name) {
    const bool plain = std::all_of(name.begin(), name.end(), [](char c) { return c > 0x20 && c < 0x7f; });
    require(!name.empty() && plain, what, ": ", quoted(name), " cannot be a name in a PLY file (ASCII without blanks)");
}

void check(const PlyElement& element) {
    require_one_word("element", element.name);
    for (std::size_t c = 0; c < element.columns.size(); ++c) {
        const PlyColumn& column = element.columns[c];
        require_one_word("column", column.name);
        require(column.values.size() == element.count, "column ", column.name, ": ", column.values.size(),
                " values for ", element.count, " rows of ", element.name);
        for (std::size_t other = 0; other < c; ++other)
            require(element.columns[other].name != column.name, "column ", column.name, ": given twice");
        if (is_integer(column.type))
            for (std::size_t i = 0; i < element.count; ++i)
                require(fits(column.values[i], column.type), "column ", column.name, "[", i, "]: ", column.values[i],
                        " does not fit the type ", name_of(column.type));
    }
}

void check(const Polygons& faces, const std::vector<PlyElement>& elements) {
    std::size_t vertices = 0, rows = 0;
    for (const PlyElement& e : elements) {
        if (e.name == "vertex") vertices = e.count;
        if (e.name == "face") rows = e.count;
    }
    require(faces.size() == rows, "faces: ", faces.size(), " polygons for ", rows, " rows of the element face");
    require(faces.begin.front() == 0 && faces.begin.back() == faces.corners.size() &&
                std::is_sorted(faces.begin.begin(), faces.begin.end()),
            "faces: offsets must ascend from 0 to the number of corners");
    for (const std::uint32_t corner : faces.corners)
        require(corner < vertices && corner <= 0x7fffffffu, "faces: corner ", corner, " of ", vertices, " vertices");
}

// Corners are int: some readers take nothing else. Their number is uchar wherever that is enough, for the same reason.
PlyType count_type_of(const Polygons& faces) {
    std::size_t most = 0;
    for (std::size_t i = 0; i < faces.size(); ++i) most = std::max(most, faces.begin[i + 1] - faces.begin[i]);
    return most < 256 ? PlyType::uint8 : PlyType::int32;
}

std::string header_of(const std::vector<PlyElement>& elements, PlyType count_type,
                      const std::vector<std::string>& comments) {
    std::string header = "ply\nformat binary_little_endian 1.0\n";
    for (const std::string& comment : comments) {
        require(comment.find_first_of("\r\n") == std::string::npos, "comments: one line each, got ", quoted(comment));
        header += "comment " + comment + "\n";
    }
    for (const PlyElement& element : elements) {
        header += message("element ", element.name, " ", element.count, "\n");
        if (element.name == "face") header += message("property list ", name_of(count_type), " int vertex_indices\n");
        for (const PlyColumn& column : element.columns)
            header += message("property ", name_of(column.type), " ", column.name, "\n");
    }
    return header + "end_header\n";
}

void append_rows(std::string& bytes, const PlyElement& element) {
    std::size_t stride = 0;
    for (const PlyColumn& column : element.columns) stride += size_of(column.type);
    const std::size_t begin = bytes.size();
    bytes.resize(begin + element.count * stride);
    std::size_t offset = begin;
    for (const PlyColumn& column : element.columns) {
        char* to = bytes.data() + offset;
        for (const double value : column.values) {
            store(to, column.type, value);
            to += stride;
        }
        offset += size_of(column.type);
    }
}

void append_faces(std::string& bytes, const PlyElement& element, const Polygons& faces, PlyType count_type) {
    char value[8];
    const auto append = [&](PlyType type, double number) {
        store(value, type, number);
        bytes.append(value, size_of(type));
    };
    for (std::size_t i = 0; i < faces.size(); ++i) {
        append(count_type, static_cast<double>(faces.begin[i + 1] - faces.begin[i]));
        for (std::size_t k = faces.begin[i]; k < faces.begin[i + 1]; ++k) append(PlyType::int32, faces.corners[k]);
        for (const PlyColumn& column : element.columns) append(column.type, column.values[i]);
    }
}

}  // namespace

void write_ply(const std::string& path, const std::vector<PlyElement>& elements, const Polygons& faces,
               const std::vector<std::string>& comments) {
    for (std::size_t e = 0; e < elements.size(); ++e) {
        check(elements[e]);
        for (std::size_t other = 0; other < e; ++other)
            require(elements[other].name != elements[e].name, "element ", elements[e].name, ": given twice");
    }
    check(faces, elements);
    const PlyType count_type = count_type_of(faces);
    std::string bytes = header_of(elements, count_type, comments);
    for (const PlyElement& element : elements) {
        if (element.name == "face")
            append_faces(bytes, element, faces, count_type);
        else
            append_rows(bytes, element);
    }
    write_bytes(path, bytes);
}

}  // namespace surflux
