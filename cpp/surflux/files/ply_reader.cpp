#include <algorithm>
#include <cmath>
#include <cstring>

#include "surflux/core/error.h"
#include "surflux/core/file_bytes.h"
#include "surflux/files/ply.h"
#include "surflux/files/ply_header.h"
#include "surflux/files/text_lines.h"

namespace surflux {

namespace {

template <class T>
T load(const char* from, bool swapped) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, from, sizeof(T));
    if (swapped) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
}

// Calls f(T()) with the C++ type that holds a PLY type.
template <class F>
auto with_type(PlyType type, const F& f) {
    switch (type) {
        case PlyType::int8:
            return f(std::int8_t());
        case PlyType::uint8:
            return f(std::uint8_t());
        case PlyType::int16:
            return f(std::int16_t());
        case PlyType::uint16:
            return f(std::uint16_t());
        case PlyType::int32:
            return f(std::int32_t());
        case PlyType::uint32:
            return f(std::uint32_t());
        case PlyType::float32:
            return f(float());
        case PlyType::float64:
            break;
    }
    return f(double());
}

double load(const char* from, PlyType type, bool swapped) {
    return with_type(type, [&](auto zero) { return static_cast<double>(load<decltype(zero)>(from, swapped)); });
}

// Where the values of one property go.
struct Sink {
    const PlyProperty* property;
    std::vector<double>* values = nullptr;  // of a scalar that is kept
    Polygons* polygons = nullptr;           // of the list of face corners
    PlyLists* lists = nullptr;              // of another list that is kept
};

class BodyReader {
public:
    BodyReader(const std::string& path, const std::string& bytes, const PlyHeader& header, PlyData& data)
        : path_(path),
          bytes_(bytes),
          header_(header),
          data_(data),
          lines_(bytes, header.body, header.body_line, header.newline),
          at_(header.body) {}

    void read(const std::vector<std::string>& keep) {
        if (const PlyElement* vertex = data_.find("vertex")) vertices_ = vertex->count;
        for (std::size_t e = 0; e < header_.elements.size(); ++e) {
            const PlyHeader::Element& described = header_.elements[e];
            element_ = &data_.elements[e];
            check_promise(described);
            const bool kept = std::find(keep.begin(), keep.end(), described.name) != keep.end();
            const std::vector<Sink> sinks = sinks_of(described, kept);
            const bool fixed = std::none_of(described.properties.begin(), described.properties.end(),
                                            [](const PlyProperty& p) { return p.is_list; });
            if (sinks.empty()) continue;  // rows without properties take no room
            if (header_.format == PlyFormat::ascii)
                read_ascii(sinks, kept);
            else if (fixed)
                read_table(sinks);
            else
                read_rows(sinks);
        }
        check_end();
    }

private:
    [[noreturn]] void fail(const std::string& place, const std::string& reason) const {
        throw FileError(shown_path(path_), place, reason);
    }
    [[noreturn]] void fail_at_byte(std::size_t offset, const std::string& reason) const {
        fail(message("byte ", offset), reason);
    }
    [[noreturn]] void fail_at_line(const std::string& reason) const { fail(message("line ", lines_.number()), reason); }

    bool swapped() const {
        const std::uint16_t one = 1;
        char first;
        std::memcpy(&first, &one, 1);
        const bool machine_is_little = first == 1;
        return (header_.format == PlyFormat::little_endian) != machine_is_little;
    }

    std::string row_name(std::size_t row) const {
        const std::string name = quoted(element_->name);
        return message(name.substr(1, name.size() - 2), " ", row);
    }

    // Refuses, before any memory is asked for, a count that the rest of the file cannot hold.
    void check_promise(const PlyHeader::Element& described) const {
        const bool ascii = header_.format == PlyFormat::ascii;
        std::size_t least = 0;  // bytes per row
        for (const PlyProperty& p : described.properties)
            least += ascii ? 2 : size_of(p.is_list ? p.count_type : p.type);  // a digit and what ends it
        const std::size_t rest = bytes_.size() - (ascii ? lines_.offset() : at_);
        if (least == 0 || described.count <= (rest + (ascii ? 1 : 0)) / least) return;
        const std::string reason =
            message("truncated: the header promises ", described.count, " of element ", quoted(described.name),
                    ", at least ", least, " bytes each, but ", rest, " bytes are left in the file");
        if (ascii) fail(message("line ", lines_.number() + 1), reason);
        fail_at_byte(at_, reason);
    }

    std::vector<Sink> sinks_of(const PlyHeader::Element& described, bool kept) {
        std::vector<Sink> sinks;
        // Room for all columns first: sinks point into them.
        if (kept)
            for (const PlyProperty& p : described.properties)
                if (!p.is_list) element_->columns.push_back({p.name, p.type, std::vector<double>(described.count)});
        std::size_t column = 0;
        bool has_polygons = false, has_texcoord = false;
        for (const PlyProperty& p : described.properties) {
            Sink sink{&p};
            if (kept && !p.is_list) sink.values = &element_->columns[column++].values;
            if (kept && p.is_list && described.name == "face" && !has_polygons &&
                (p.name == "vertex_indices" || p.name == "vertex_index")) {
                sink.polygons = &data_.faces;
                has_polygons = true;
                if (!is_integer(p.type))
                    fail("", message("face corners (", p.name, ") are of type ", name_of(p.type),
                                     "; wanted a type of integers"));
            }
            if (kept && p.is_list && described.name == "face" && !has_texcoord && p.name == "texcoord") {
                sink.lists = &data_.texcoord;
                has_texcoord = true;
            }
            sinks.push_back(sink);
        }
        return sinks;
    }

    // An empty text, or what is wrong with the corner of a face.
    std::string corner_problem(double corner, std::size_t row) const {
        if (corner >= 0.0 && corner < static_cast<double>(vertices_)) return "";
        return message(row_name(row), " has the corner ", corner, "; the file has ", vertices_,
                       " vertices, numbered from 0");
    }

    std::string coordinate_problem(const PlyColumn& column, std::size_t row) const {
        return message(row_name(row), ": ", column.name, " is ", column.values[row], "; wanted a finite number");
    }

    // ---- ascii: one row on a line, blank lines between them allowed

    double number(std::size_t row, const Sink& sink, PlyType type) {
        double value = 0.0;
        std::string_view word;
        switch (lines_.next_number(value, word)) {
            case TextLines::Word::none:
                fail_at_line(message(row_name(row), " ends before ", quoted(sink.property->name)));
            case TextLines::Word::garbage:
                fail_at_line(message(row_name(row), ": ", quoted(sink.property->name), " is ", quoted(word),
                                     ", which is no number"));
            case TextLines::Word::number:
                break;
        }
        if (!fits(value, type))
            fail_at_line(message(row_name(row), ": ", quoted(sink.property->name), " is ", quoted(word),
                                 ", which its type ", name_of(type), " does not hold"));
        return value;
    }

    void read_ascii(const std::vector<Sink>& sinks, bool kept) {
        const std::vector<const PlyColumn*> coordinates = coordinate_columns();
        for (std::size_t row = 0; row < element_->count; ++row) {
            if (!lines_.advance())
                fail(message("line ", lines_.number()),
                     message("truncated: the header promises ", element_->count, " of element ", quoted(element_->name),
                             ", but ", row, " are in the file"));
            if (!kept) continue;
            for (const Sink& sink : sinks) {
                if (sink.property->is_list)
                    read_ascii_list(row, sink);
                else
                    (*sink.values)[row] = number(row, sink, sink.property->type);
            }
            std::string_view word;
            if (lines_.next_word(word))
                fail_at_line(message(row_name(row), " goes on with ", quoted(word), " after its last property ",
                                     quoted(sinks.back().property->name)));
            for (const PlyColumn* column : coordinates)
                if (!std::isfinite(column->values[row])) fail_at_line(coordinate_problem(*column, row));
        }
    }

    void read_ascii_list(std::size_t row, const Sink& sink) {
        const double count = number(row, sink, sink.property->count_type);
        if (count < 0.0)
            fail_at_line(message(row_name(row), ": ", quoted(sink.property->name), " has ", count, " entries"));
        for (double i = 0.0; i < count; ++i) {
            const double value = number(row, sink, sink.property->type);
            if (sink.lists) sink.lists->values.push_back(value);
            if (!sink.polygons) continue;
            const std::string problem = corner_problem(value, row);
            if (!problem.empty()) fail_at_line(problem);
            sink.polygons->corners.push_back(static_cast<std::uint32_t>(value));
        }
        if (sink.lists) sink.lists->begin.push_back(sink.lists->values.size());
        if (sink.polygons) sink.polygons->begin.push_back(sink.polygons->corners.size());
    }

    // ---- binary

    // All rows have the same length: column by column.
    void read_table(const std::vector<Sink>& sinks) {
        std::size_t stride = 0;
        for (const Sink& sink : sinks) stride += size_of(sink.property->type);
        const std::size_t begin = at_, count = element_->count;
        std::size_t offset = 0;
        for (const Sink& sink : sinks) {
            if (sink.values) {
                const char* from = bytes_.data() + begin + offset;
                with_type(sink.property->type, [&](auto zero) {
                    for (std::size_t i = 0; i < count; ++i)
                        (*sink.values)[i] = static_cast<double>(load<decltype(zero)>(from + i * stride, swapped()));
                });
            }
            offset += size_of(sink.property->type);
        }
        at_ += count * stride;
        for (const PlyColumn* column : coordinate_columns())
            for (std::size_t i = 0; i < count; ++i)
                if (!std::isfinite(column->values[i])) fail_at_byte(begin + i * stride, coordinate_problem(*column, i));
    }

    void read_rows(const std::vector<Sink>& sinks) {
        const std::vector<const PlyColumn*> coordinates = coordinate_columns();
        for (std::size_t row = 0; row < element_->count; ++row) {
            const std::size_t begin = at_;
            for (const Sink& sink : sinks) {
                if (sink.property->is_list) {
                    read_list(row, sink);
                } else {
                    const char* from = take(row, size_of(sink.property->type), 1);
                    if (sink.values) (*sink.values)[row] = load(from, sink.property->type, swapped());
                }
            }
            for (const PlyColumn* column : coordinates)
                if (!std::isfinite(column->values[row])) fail_at_byte(begin, coordinate_problem(*column, row));
        }
    }

    void read_list(std::size_t row, const Sink& sink) {
        const PlyProperty& p = *sink.property;
        const std::size_t begin = at_;
        const double claimed = load(take(row, size_of(p.count_type), 1), p.count_type, swapped());
        if (claimed < 0.0)
            fail_at_byte(begin, message(row_name(row), ": ", quoted(p.name), " has ", claimed, " entries"));
        const auto count = static_cast<std::size_t>(claimed);
        const std::size_t size = size_of(p.type);
        const char* from = take(row, size, count);
        if (sink.lists) {
            for (std::size_t i = 0; i < count; ++i)
                sink.lists->values.push_back(load(from + i * size, p.type, swapped()));
            sink.lists->begin.push_back(sink.lists->values.size());
        }
        if (!sink.polygons) return;
        for (std::size_t i = 0; i < count; ++i) {
            const double corner = load(from + i * size, p.type, swapped());
            const std::string problem = corner_problem(corner, row);
            if (!problem.empty()) fail_at_byte(begin, problem);
            sink.polygons->corners.push_back(static_cast<std::uint32_t>(corner));
        }
        sink.polygons->begin.push_back(sink.polygons->corners.size());
    }

    const char* take(std::size_t row, std::size_t size, std::size_t count) {
        if (count > (bytes_.size() - at_) / size)
            fail_at_byte(at_, message("truncated: ", row_name(row), " needs ", count * size, " more bytes, but ",
                                      bytes_.size() - at_, " are left in the file"));
        const char* from = bytes_.data() + at_;
        at_ += count * size;
        return from;
    }

    // ---- both

    std::vector<const PlyColumn*> coordinate_columns() const {
        std::vector<const PlyColumn*> out;
        if (element_->name == "vertex")
            for (const PlyColumn& c : element_->columns)
                if (c.name == "x" || c.name == "y" || c.name == "z") out.push_back(&c);
        return out;
    }

    // More data than the header promises means that its counts or types are wrong: what was read is not to be trusted.
    void check_end() {
        const std::string reason =
            "the file goes on after all that its header promises; a count or a type there is wrong";
        if (header_.format == PlyFormat::ascii) {
            if (lines_.advance()) fail_at_line(reason);
        } else if (bytes_.find_first_not_of("\r\n \t", at_) != std::string::npos) {
            fail_at_byte(at_, reason);
        }
    }

    const std::string& path_;
    const std::string& bytes_;
    const PlyHeader& header_;
    PlyData& data_;
    TextLines lines_;
    std::size_t at_;
    std::size_t vertices_ = 0;
    PlyElement* element_ = nullptr;
};

}  // namespace

const PlyElement* PlyData::find(const std::string& element) const {
    for (const PlyElement& e : elements)
        if (e.name == element) return &e;
    return nullptr;
}

PlyData read_ply(const std::string& path, const std::vector<std::string>& keep) {
    return parse_ply(path, read_bytes(path), keep);
}

PlyData parse_ply(const std::string& path, const std::string& bytes, const std::vector<std::string>& keep) {
    const PlyHeader header = parse_ply_header(path, bytes);
    PlyData data;
    for (const PlyHeader::Element& e : header.elements) data.elements.push_back({e.name, e.count, {}});
    data.comments = header.comments;
    data.object_info = header.object_info;
    BodyReader(path, bytes, header, data).read(keep);
    return data;
}

}  // namespace surflux
