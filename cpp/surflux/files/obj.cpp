#include "surflux/files/obj.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string_view>

#include "surflux/core/error.h"
#include "surflux/core/file_bytes.h"
#include "surflux/files/text_lines.h"

namespace surflux {

namespace {

constexpr double largest_place = 1e9;  // on a texture, which repeats itself

class ObjReader {
public:
    ObjReader(const std::string& path, const std::string& bytes)
        : path_(path), lines_(bytes, bytes.rfind("\xef\xbb\xbf", 0) == 0 ? 3 : 0) {}  // a byte order mark

    ObjData read() {
        while (lines_.advance()) {
            std::string_view keyword;
            if (!next_word(keyword)) continue;
            if (keyword == "v")
                read_vertex();
            else if (keyword == "vt")
                read_texture_place();
            else if (keyword == "f")
                read_face();
            else if (keyword == "mtllib")
                data_.libraries.push_back(rest_of_statement());
            else if (keyword == "usemtl")
                use_material(rest_of_statement());
            // A statement that goes on over several lines must not begin another one.
            std::string_view rest;
            while (next_word(rest)) continue;
        }
        check_corners();
        const std::size_t places = data_.texture_places.size();
        if (places == 0) std::vector<std::uint32_t>().swap(data_.texture_corners);
        for (std::uint32_t& k : data_.texture_corners)
            if (k >= places) k = ObjData::no_place;
        if (has_colors_) data_.colors = std::move(colors_);
        return std::move(data_);
    }

private:
    [[noreturn]] void fail(std::size_t line, const std::string& reason) const {
        throw FileError(shown_path(path_), message("line ", line), reason);
    }

    // Up to a comment; goes on to the next line after a backslash.
    bool next_word(std::string_view& word) {
        while (lines_.next_word(word)) {
            if (word[0] == '#') {
                while (lines_.next_word(word)) continue;
                return false;
            }
            if (word.back() != '\\') return true;
            word.remove_suffix(1);
            if (!lines_.advance()) return !word.empty();
            if (!word.empty()) return true;
        }
        return false;
    }

    void read_vertex() {
        const std::size_t line = lines_.number();
        double values[6] = {};
        std::size_t count = 0;
        for (std::string_view word; next_word(word); ++count) {
            if (count >= 6) continue;
            if (!parse_number(word, values[count])) fail(line, quoted(word) + " is no number");
        }
        const Vec3 position{values[0], values[1], values[2]};
        if (count < 3) fail(line, message("a vertex of ", count, " numbers; wanted 3 coordinates"));
        if (!is_finite(position)) fail(line, "a coordinate is not finite");
        data_.vertices.push_back(position);
        // A fourth number alone is a weight, which polygons have no use for.
        constexpr double none = std::numeric_limits<double>::quiet_NaN();
        colors_.push_back(count >= 6 ? Rgb{values[3], values[4], values[5]} : Rgb{none, none, none});
        has_colors_ |= count >= 6;
    }

    // Where a number is missing or not finite, 0: it takes no surface away.
    void read_texture_place() {
        double values[2] = {};
        std::size_t count = 0;
        for (std::string_view word; next_word(word); ++count)
            if (count < 2 && !(parse_number(word, values[count]) && std::abs(values[count]) < largest_place))
                values[count] = 0.0;
        data_.texture_places.push_back({static_cast<float>(values[0]), static_cast<float>(values[1])});
    }

    void read_face() {
        const std::size_t line = lines_.number();
        for (std::string_view word; next_word(word);) {
            data_.faces.corners.push_back(corner(word, line));
            data_.texture_corners.push_back(texture_corner(word));
        }
        const std::size_t count = data_.faces.corners.size() - data_.faces.begin.back();
        if (count < 3) fail(line, message("a face of ", count, " corners; wanted 3 or more"));
        data_.faces.begin.push_back(data_.faces.corners.size());
        data_.face_materials.push_back(material_);
        face_lines_.push_back(line);
    }

    // With blanks, and what may be a comment; goes on to the next line after a backslash, which ends no comment.
    std::string rest_of_statement() {
        std::string out(lines_.rest());
        const auto goes_on = [&] {
            const bool has_comment =
                out.rfind('#', 0) == 0 || out.find(" #") != std::string::npos || out.find("\t#") != std::string::npos;
            return !has_comment && !out.empty() && out.back() == '\\';
        };
        while (goes_on() && lines_.advance()) {
            out.back() = ' ';
            out.append(lines_.rest());
        }
        return out;
    }

    void use_material(std::string name) {
        const auto [known, added] =
            numbers_.try_emplace(std::move(name), static_cast<std::uint32_t>(data_.materials.size()));
        if (added) data_.materials.push_back(known->first);
        material_ = known->second;
    }

    // `7`, `7/1`, `7//2` or `7/1/2`: the position's index is the first.
    std::uint32_t corner(std::string_view word, std::size_t line) const {
        std::int64_t index = 0;
        const char* end = word.data() + word.size();
        const auto [stop, error] = std::from_chars(word.data(), end, index);
        if (error != std::errc() || (stop != end && *stop != '/'))
            fail(line, quoted(word) + " is no corner of a face; wanted an index as in 7, 7/1, 7//2 or 7/1/2");
        const auto vertices = static_cast<std::int64_t>(data_.vertices.size());
        const std::int64_t from_zero = index > 0 ? index - 1 : index + vertices;
        if (index == 0 || from_zero < 0 || from_zero > 0xfffffffell)
            fail(line, message("a face has the corner ", index, " after ", vertices, " vertices"));
        return static_cast<std::uint32_t>(from_zero);
    }

    std::uint32_t texture_corner(std::string_view word) const {
        const std::size_t slash = word.find('/');
        if (slash == std::string_view::npos) return ObjData::no_place;
        std::int64_t index = 0;
        std::from_chars(word.data() + slash + 1, word.data() + word.size(), index);
        const std::int64_t from_zero =
            index > 0 ? index - 1 : index + static_cast<std::int64_t>(data_.texture_places.size());
        return index == 0 || from_zero < 0 || from_zero >= std::int64_t{ObjData::no_place}
                   ? ObjData::no_place
                   : static_cast<std::uint32_t>(from_zero);
    }

    // At the end: a face may come before its vertices.
    void check_corners() const {
        const std::size_t vertices = data_.vertices.size();
        for (std::size_t i = 0; i < data_.faces.size(); ++i)
            for (std::size_t k = data_.faces.begin[i]; k < data_.faces.begin[i + 1]; ++k)
                if (data_.faces.corners[k] >= vertices)
                    fail(face_lines_[i], message("a face has the corner ", std::uint64_t{data_.faces.corners[k]} + 1,
                                                 ", but the file has ", vertices, " vertices"));
    }

    const std::string& path_;
    TextLines lines_;
    ObjData data_;
    std::vector<Rgb> colors_;
    bool has_colors_ = false;
    std::map<std::string, std::uint32_t> numbers_;  // of materials
    std::uint32_t material_ = ObjData::no_material;
    std::vector<std::size_t> face_lines_;
};

}  // namespace

ObjData read_obj(const std::string& path) { return parse_obj(path, read_bytes(path)); }

ObjData parse_obj(const std::string& path, const std::string& bytes) { return ObjReader(path, bytes).read(); }

}  // namespace surflux
