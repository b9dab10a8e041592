#include "surflux/image/claims.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>

#include "surflux/core/error.h"

namespace surflux {

namespace {

// What a file says, for a message: Python wants UTF-8.
std::string printable(std::string text) {
    for (char& c : text)
        if (c < 0x20 || c > 0x7e) c = '?';
    return text.substr(0, 40);
}

namespace fs = std::filesystem;

// A file read piece by piece; a piece that is not all there is an error at its place.
class Pieces {
public:
    explicit Pieces(const std::string& path) : path_(path), in_(path, std::ios::binary), size_(fs::file_size(path)) {}

    std::uint64_t at() const { return at_; }
    std::uint64_t left() const { return size_ - at_; }
    [[noreturn]] void fail(const std::string& reason) const { throw FileError(path_, message("byte ", at_), reason); }

    void take(void* to, std::uint64_t count) {
        if (count > left() || !in_.read(static_cast<char*>(to), static_cast<std::streamsize>(count)))
            fail("the file ends early");
        at_ += count;
    }
    void skip(std::uint64_t count) {
        if (count > left()) fail("the file ends early");
        at_ += count;
        in_.seekg(static_cast<std::streamoff>(at_));
    }

private:
    const std::string& path_;
    std::ifstream in_;
    std::uint64_t size_, at_ = 0;
};

std::int32_t little_endian(const unsigned char* bytes) {
    const std::uint32_t value = std::uint32_t{bytes[0]} | (std::uint32_t{bytes[1]} << 8) |
                                (std::uint32_t{bytes[2]} << 16) | (std::uint32_t{bytes[3]} << 24);
    return static_cast<std::int32_t>(value);
}

// Bytes of the types of attributes that always have as many. OpenEXR reads those, whatever the file says their size is,
// and takes what follows for the next attribute.
struct FixedSize {
    std::string_view type;
    std::int32_t bytes;
};
constexpr std::array<FixedSize, 24> fixed_sizes{{{"box2f", 16},
                                                 {"box2i", 16},
                                                 {"chromaticities", 32},
                                                 {"compression", 1},
                                                 {"deepImageState", 1},
                                                 {"double", 8},
                                                 {"envmap", 1},
                                                 {"float", 4},
                                                 {"int", 4},
                                                 {"keycode", 28},
                                                 {"lineOrder", 1},
                                                 {"m33d", 72},
                                                 {"m33f", 36},
                                                 {"m44d", 128},
                                                 {"m44f", 64},
                                                 {"rational", 8},
                                                 {"tiledesc", 9},
                                                 {"timecode", 8},
                                                 {"v2d", 16},
                                                 {"v2f", 8},
                                                 {"v2i", 8},
                                                 {"v3d", 24},
                                                 {"v3f", 12},
                                                 {"v3i", 12}}};

// OpenEXR, "File Layout" of its documentation.
class ExrHeaders {
public:
    explicit ExrHeaders(const std::string& path) : path_(path), file_(path) {}

    void check() {
        unsigned char head[8];
        if (file_.left() < sizeof head) file_.fail("the file ends early");
        file_.take(head, sizeof head);
        if (std::memcmp(head, "\x76\x2f\x31\x01", 4) != 0) throw FileError(path_, "byte 0", "not an EXR file");
        const bool several = (little_endian(head + 4) & 0x1000) != 0;
        do {
            if (!check_header()) return;
        } while (several);
    }

private:
    // False at the empty header that ends the headers of several parts.
    bool check_header() {
        double width = 0.0, height = 0.0, channels = 0.0, tile_width = 1.0, tile_height = 1.0;
        bool empty = true;
        for (std::string name = word(); !name.empty(); name = word()) {
            empty = false;
            const std::string type = word();
            unsigned char four[4];
            file_.take(four, sizeof four);
            const std::int32_t size = little_endian(four);
            if (size < 0 || static_cast<std::uint64_t>(size) > file_.left())
                file_.fail(message("the attribute '", printable(name), "' claims ", size, " bytes, but ", file_.left(),
                                   " are left in the file"));
            check_size(name, type, size);
            unsigned char value[16] = {};
            const std::uint64_t begin = file_.at(), length = static_cast<std::uint64_t>(size);
            if (type == "chlist") {
                channels = count_channels(begin + length);
            } else if (type == "stringvector") {
                walk_strings(begin + length);
            } else {
                file_.take(value, std::min<std::uint64_t>(length, sizeof value));
                if (type == "preview") {
                    const double pixels = static_cast<double>(static_cast<std::uint32_t>(little_endian(value))) *
                                          static_cast<std::uint32_t>(little_endian(value + 4));
                    if (8.0 + 4.0 * pixels != static_cast<double>(length))
                        file_.fail("the preview claims another size than its attribute");
                } else if (name == "dataWindow") {
                    width = 1.0 + little_endian(value + 8) - static_cast<double>(little_endian(value));
                    height = 1.0 + little_endian(value + 12) - static_cast<double>(little_endian(value + 4));
                } else if (name == "tiles") {
                    tile_width = static_cast<std::uint32_t>(little_endian(value));
                    tile_height = static_cast<std::uint32_t>(little_endian(value + 4));
                }
            }
            file_.skip(begin + length - file_.at());
        }
        if (empty) return false;
        if (!(width >= 1.0) || !(height >= 1.0)) throw FileError(path_, "", "an image without pixels");
        check_pixel_claim(path_, width, height, channels);
        check_chunk_claim(path_, width, lines_at_once, channels);
        check_chunk_claim(path_, tile_width, tile_height, channels);
        return true;
    }

    std::string word() {
        std::string out;
        char c = 0;
        for (file_.take(&c, 1); c != '\0'; file_.take(&c, 1)) {
            out += c;
            if (out.size() > 255) file_.fail("a name of more than 255 letters");
        }
        return out;
    }

    void check_size(const std::string& name, const std::string& type, std::int32_t size) const {
        for (const FixedSize& fixed : fixed_sizes)
            if (fixed.type == type && fixed.bytes != size)
                file_.fail(message("the attribute '", printable(name), "' has ", size, " bytes; wanted ", fixed.bytes,
                                   " of type ", type));
    }

    // Each a name and 16 bytes; an empty name ends them.
    double count_channels(std::uint64_t end) {
        double count = 0.0;
        for (; !word().empty(); count += 1.0) file_.skip(16);
        if (file_.at() != end) file_.fail("the list of channels does not end where its attribute does");
        return count;
    }

    void walk_strings(std::uint64_t end) {
        while (file_.at() < end) {
            unsigned char four[4];
            file_.take(four, sizeof four);
            const std::int32_t length = little_endian(four);
            if (length < 0) file_.fail("a text of negative length");
            file_.skip(static_cast<std::uint64_t>(length));
        }
        if (file_.at() != end) file_.fail("a list of texts does not end where its attribute does");
    }

    const std::string& path_;
    Pieces file_;
};

}  // namespace

void check_pixel_claim(const std::string& path, double width, double height, double channels) {
    const std::uint64_t size = fs::file_size(path);
    if (4.0 * width * height * channels > 1e5 * static_cast<double>(size))
        throw FileError(path, "",
                        message("claims ", static_cast<std::int64_t>(width), " x ", static_cast<std::int64_t>(height),
                                " pixels of ", channels, " channels, more than its ", size, " bytes can hold"));
}

void check_chunk_claim(const std::string& path, double width, double height, double channels) {
    if (4.0 * width * height * channels > 256e6) check_pixel_claim(path, width, height, channels);
}

void check_exr(const std::string& path) { ExrHeaders(path).check(); }

HdrHeader check_hdr(const std::string& path) {
    constexpr double exposures[2] = {1e-30, 1e30};  // beyond, pixels would be infinite or black
    HdrHeader out;
    std::ifstream in(path, std::ios::binary);
    std::string line;
    while (std::getline(in, line) && !line.empty()) {
        const std::size_t equals = line.find('=');
        const std::string name = line.substr(0, equals);
        if (equals == std::string::npos || (name != "EXPOSURE" && name != "COLORCORR")) continue;
        std::istringstream values(line.substr(equals + 1));
        double of[3] = {1.0, 1.0, 1.0};
        bool whole = static_cast<bool>(values >> of[0]);
        if (name == "EXPOSURE")
            of[1] = of[2] = of[0];
        else
            whole = whole && values >> of[1] >> of[2];
        for (int c = 0; c < 3; ++c) {
            out.exposure[c] *= of[c];
            if (!whole || !(of[c] > 0.0) || !(out.exposure[c] >= exposures[0] && out.exposure[c] <= exposures[1]))
                throw FileError(path, "",
                                message("its ", name, " is '", printable(line.substr(equals + 1)),
                                        "'; wanted above 0, and all of them together 1e-30 to 1e30"));
        }
    }
    std::string axes[2];
    std::int32_t sizes[2];  // what is larger fails to be read
    if (!(in >> axes[0] >> sizes[0] >> axes[1] >> sizes[1])) return out;
    const std::size_t across = axes[1].find('X') == std::string::npos ? 0 : 1;
    check_pixel_claim(path, sizes[across], sizes[1 - across], 3);
    check_chunk_claim(path, sizes[across], lines_at_once, 3);
    if (across == 0)
        throw FileError(path, "",
                        message("its lines run up or down ('", printable(axes[0]), " n ", printable(axes[1]),
                                " m'); wanted Y first"));
    out.from_bottom = axes[0] == "+Y";
    out.from_right = axes[1] == "-X";
    return out;
}

void check_png(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    const auto size = static_cast<std::uint64_t>(fs::file_size(path));
    const auto cut_off = [&path](std::uint64_t at) {
        return FileError(path, message("byte ", at), "the file ends early");
    };
    unsigned char head[8];
    const auto next = [&] { return static_cast<bool>(in.read(reinterpret_cast<char*>(head), sizeof head)); };
    if (!next() || std::memcmp(head, "\x89PNG\r\n\x1a\n", 8) != 0) throw FileError(path, "byte 0", "not a PNG file");
    for (std::uint64_t at = 8; next();) {
        const std::uint64_t length = (std::uint64_t{head[0]} << 24) | (std::uint64_t{head[1]} << 16) |
                                     (std::uint64_t{head[2]} << 8) | std::uint64_t{head[3]};
        if (at + 12 + length > size) throw cut_off(at);  // length, type, data, check sum
        if (std::memcmp(head + 4, "IEND", 4) == 0) return;
        at += 12 + length;
        in.seekg(static_cast<std::streamoff>(at));
    }
    throw cut_off(size);
}

}  // namespace surflux
