#include "surflux/files/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>

#include "surflux/core/error.h"
#include "surflux/core/file_bytes.h"

namespace surflux {

namespace {

struct TypeRow {
    const char* name;
    const char* other_name;
    std::size_t size;
    double lowest, highest;  // of the integers
};

constexpr std::array<TypeRow, 8> types{{{"char", "int8", 1, -128.0, 127.0},
                                        {"uchar", "uint8", 1, 0.0, 255.0},
                                        {"short", "int16", 2, -32768.0, 32767.0},
                                        {"ushort", "uint16", 2, 0.0, 65535.0},
                                        {"int", "int32", 4, -2147483648.0, 2147483647.0},
                                        {"uint", "uint32", 4, 0.0, 4294967295.0},
                                        {"float", "float32", 4, 0.0, 0.0},
                                        {"double", "float64", 8, 0.0, 0.0}}};

const TypeRow& row_of(PlyType type) { return types[static_cast<std::size_t>(type)]; }

bool find_type(std::string_view name, PlyType& type) {
    for (std::size_t i = 0; i < types.size(); ++i) {
        if (name != types[i].name && name != types[i].other_name) continue;
        type = static_cast<PlyType>(i);
        return true;
    }
    return false;
}

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

// At most six: no line of a header has more, but for comments.
std::vector<std::string_view> words_of(std::string_view line) {
    std::vector<std::string_view> words;
    for (std::size_t i = 0; i < line.size() && words.size() < 6;) {
        if (is_blank(line[i])) {
            ++i;
            continue;
        }
        std::size_t end = i;
        while (end < line.size() && !is_blank(line[end])) ++end;
        words.push_back(line.substr(i, end - i));
        i = end;
    }
    return words;
}

class HeaderParser {
public:
    HeaderParser(const std::string& path, std::string_view bytes) : path_(path), bytes_(bytes) {}

    PlyHeader parse() {
        check_first_line();
        bool has_format = false;
        for (;;) {
            const std::string_view line = next_line();
            const std::vector<std::string_view> words = words_of(line);
            if (words.empty()) continue;
            const std::string_view keyword = words[0];
            if (keyword == "end_header") break;
            if (keyword == "comment" || keyword == "obj_info") {
                auto& texts = keyword == "comment" ? header_.comments : header_.object_info;
                texts.push_back(rest_of(line, keyword));
            } else if (keyword == "format") {
                if (has_format) fail("a second format line");
                read_format(words);
                has_format = true;
            } else if (keyword == "element") {
                read_element(words);
            } else if (keyword == "property") {
                read_property(words);
            } else {
                fail("the header has a line that begins with " + quoted(keyword) +
                     "; wanted comment, obj_info, element, property or end_header");
            }
        }
        if (!has_format) fail("the header has no format line");
        header_.body = at_;
        header_.body_line = line_ + 1;
        return header_;
    }

private:
    [[noreturn]] void fail(const std::string& reason) const {
        throw FileError(shown_path(path_), message("line ", line_), reason);
    }

    void check_first_line() {
        if (bytes_.empty()) throw FileError(shown_path(path_), "", "the file is empty");
        constexpr std::string_view git_lfs = "version https://git-lfs";
        if (bytes_.substr(0, git_lfs.size()) == git_lfs)
            throw FileError(shown_path(path_), "line 1",
                            "a pointer of git-lfs, not the file itself; 'git lfs pull' fetches that");
        const std::size_t end = bytes_.find_first_of("\r\n");
        if (end != std::string_view::npos && bytes_[end] == '\r' &&
            (end + 1 >= bytes_.size() || bytes_[end + 1] != '\n'))
            header_.newline = '\r';
        const std::vector<std::string_view> words = words_of(bytes_.substr(0, std::min<std::size_t>(end, 80)));
        if (words.size() != 1 || words[0] != "ply")
            throw FileError(shown_path(path_), "line 1", "not a PLY file: the first line is not 'ply'");
        line_ = 1;
        if (end == std::string_view::npos) fail_unfinished();
        at_ = bytes_.find(header_.newline) + 1;
    }

    [[noreturn]] void fail_unfinished() const { fail("the header ends before its end_header line"); }

    // Ends at '\n' (a '\r' before it is blank), or at '\r' in a file that has only those. So a binary body that
    // begins with the byte of '\n' stays whole.
    std::string_view next_line() {
        const std::size_t end = bytes_.find(header_.newline, at_);
        if (end == std::string_view::npos) {
            ++line_;
            // The last line of a file without points needs no newline.
            const std::string_view last = bytes_.substr(at_);
            const std::vector<std::string_view> words = words_of(last.substr(0, 80));
            if (words.size() != 1 || words[0] != "end_header") fail_unfinished();
            at_ = bytes_.size();
            return last;
        }
        const std::string_view line = bytes_.substr(at_, end - at_);
        at_ = end + 1;
        ++line_;
        return line;
    }

    static std::string rest_of(std::string_view line, std::string_view keyword) {
        line.remove_prefix(static_cast<std::size_t>(keyword.data() - line.data()) + keyword.size());
        while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
        while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
        return std::string(line);
    }

    void read_format(const std::vector<std::string_view>& words) {
        const std::string_view name = words.size() > 1 ? words[1] : std::string_view();
        if (name == "ascii")
            header_.format = PlyFormat::ascii;
        else if (name == "binary_little_endian")
            header_.format = PlyFormat::little_endian;
        else if (name == "binary_big_endian")
            header_.format = PlyFormat::big_endian;
        else
            fail("the format is " + quoted(name) + "; wanted ascii, binary_little_endian or binary_big_endian");
        if (words.size() != 3 || words[2] != "1.0")
            fail("the format's version is " + quoted(words.size() > 2 ? words[2] : std::string_view()) +
                 "; wanted 1.0");
    }

    void read_element(const std::vector<std::string_view>& words) {
        if (words.size() != 3) fail("wanted 'element NAME COUNT'");
        PlyHeader::Element element;
        element.name = words[1];
        const char* end = words[2].data() + words[2].size();
        const auto [stop, error] = std::from_chars(words[2].data(), end, element.count);
        if (error != std::errc() || stop != end)
            fail("the count of element " + quoted(words[1]) + " is " + quoted(words[2]) +
                 "; wanted a whole number from 0");
        if (!names_.insert(element.name).second) fail("a second element " + quoted(element.name));
        header_.elements.push_back(std::move(element));
    }

    void read_property(const std::vector<std::string_view>& words) {
        if (header_.elements.empty()) fail("a property before any element");
        PlyProperty property;
        property.is_list = words.size() > 1 && words[1] == "list";
        if (words.size() != (property.is_list ? 5u : 3u))
            fail("wanted 'property TYPE NAME' or 'property list COUNT_TYPE TYPE NAME'");
        property.name = words.back();
        property.type = type_named(words[words.size() - 2], property.name);
        if (property.is_list) {
            property.count_type = type_named(words[2], property.name);
            if (!is_integer(property.count_type))
                fail("list property " + quoted(property.name) + " is counted in " + quoted(words[2]) +
                     "; wanted a type of integers");
        }
        auto& properties = header_.elements.back().properties;
        if (!names_.insert(header_.elements.back().name + " " + property.name).second)
            fail("a second property " + quoted(property.name));
        properties.push_back(std::move(property));
    }

    PlyType type_named(std::string_view name, std::string_view property) const {
        PlyType type{};
        if (!find_type(name, type))
            fail("property " + quoted(property) + " has the unknown type " + quoted(name) +
                 "; wanted char, uchar, short, ushort, int, uint, float, double (or int8 ... float64)");
        return type;
    }

    const std::string& path_;
    std::string_view bytes_;
    std::size_t at_ = 0;
    std::size_t line_ = 0;
    PlyHeader header_;
    std::set<std::string> names_;  // of elements, and of properties behind their element's; a blank is in neither
};

}  // namespace

const char* name_of(PlyType type) { return row_of(type).name; }

PlyType ply_type(const std::string& name) {
    PlyType type{};
    require(find_type(name, type), "type: wanted one of char, uchar, short, ushort, int, uint, float, double, got ",
            quoted(name));
    return type;
}

std::size_t size_of(PlyType type) { return row_of(type).size; }

bool is_integer(PlyType type) { return type != PlyType::float32 && type != PlyType::float64; }

bool fits(double value, PlyType type) {
    if (!is_integer(type)) return true;
    const TypeRow& row = row_of(type);
    return value >= row.lowest && value <= row.highest && std::floor(value) == value;
}

PlyHeader parse_ply_header(const std::string& path, std::string_view bytes) {
    return HeaderParser(path, bytes).parse();
}

}  // namespace surflux
