#include "surflux/core/file_bytes.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>

#include <unistd.h>

#include "surflux/core/error.h"

namespace surflux {

namespace {

namespace fs = std::filesystem;

struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : text) {
        if (c >= 0x20 && c < 0x7f) {
            out += c;
        } else {
            std::array<char, 5> code{};
            std::snprintf(code.data(), code.size(), "\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(c)));
            out += code.data();
        }
    }
    return out;
}

bool is_utf8(std::string_view text) {
    int following = 0;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (following > 0) {
            if ((byte & 0xc0) != 0x80) return false;
            --following;
        } else if (byte >= 0x80) {
            following = (byte & 0xe0) == 0xc0 ? 1 : (byte & 0xf0) == 0xe0 ? 2 : (byte & 0xf8) == 0xf0 ? 3 : -1;
            if (following < 0) return false;
        }
    }
    return following == 0;
}

[[noreturn]] void fail(const std::string& path, const std::string& what) {
    throw FileError(shown_path(path), "", what + " (" + std::strerror(errno) + ")");
}

// fsync, for some file systems say only then, or at the end, that there is no room; where one cannot, it has no say.
bool reaches_disk(std::FILE* file) { return ::fsync(fileno(file)) == 0 || errno == EINVAL || errno == ENOSYS; }

void write_and_close(File file, const std::string& path, std::string_view bytes) {
    const bool whole = std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size();
    if (!whole || std::fflush(file.get()) != 0 || !reaches_disk(file.get())) fail(path, "cannot be written");
    if (std::fclose(file.release()) != 0) fail(path, "cannot be written");
}

}  // namespace

std::string quoted(std::string_view text) {
    constexpr std::size_t longest = 40;
    return "'" + escaped(text.substr(0, longest)) + (text.size() > longest ? "...'" : "'");
}

std::string shown_path(const std::string& path) { return is_utf8(path) ? path : escaped(path); }

std::string read_bytes(const std::string& path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (status.type() == fs::file_type::not_found) throw FileError(shown_path(path), "", "no such file");
    if (fs::is_directory(status)) throw FileError(shown_path(path), "", "is a folder, not a file");
    // A device or a pipe may never end.
    if (status.type() != fs::file_type::none && !fs::is_regular_file(status))
        throw FileError(shown_path(path), "", "is not a regular file");
    const File file(std::fopen(path.c_str(), "rb"));
    if (!file) fail(path, "cannot be opened");
    const std::uintmax_t size = fs::file_size(path, error);
    if (error) throw FileError(shown_path(path), "", "cannot be read (" + error.message() + ")");
    std::string bytes(static_cast<std::size_t>(size), '\0');
    // Whoever shortens the file meanwhile leaves us what is there.
    bytes.resize(std::fread(bytes.data(), 1, bytes.size(), file.get()));
    if (std::ferror(file.get()) != 0) fail(path, "cannot be read");
    return bytes;
}

void require_folder(const std::string& path) {
    std::error_code error;
    if (fs::is_directory(path, error)) throw FileError(shown_path(path), "", "is a folder, not a file");
    const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
    const fs::file_status status = fs::status(folder, error);
    if (status.type() == fs::file_type::not_found || (fs::exists(status) && !fs::is_directory(status)))
        throw FileError(shown_path(path), "", "cannot be written: there is no folder " + shown_path(folder.string()));
}

void write_bytes(const std::string& path, std::string_view bytes) {
    require_folder(path);
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (fs::exists(status) && !fs::is_regular_file(status)) {  // /dev/null and its kin are written to, not replaced
        File device(std::fopen(path.c_str(), "wb"));
        if (!device) fail(path, "cannot be written");
        return write_and_close(std::move(device), path, bytes);
    }
    error.clear();  // of a file that is not there yet
    // Behind a link, the file it leads to is replaced and the link stays.
    const fs::path target = fs::exists(status) ? fs::canonical(path, error) : fs::path(path);
    if (error) throw FileError(shown_path(path), "", "cannot be written (" + error.message() + ")");

    File file;
    std::string temporary;
    for (int attempt = 0; !file && attempt < 1000; ++attempt) {
        temporary = target.string() + ".part" + std::to_string(attempt);
        file.reset(std::fopen(temporary.c_str(), "wbx"));  // x: never a file that somebody else has
        if (!file && errno != EEXIST) fail(path, "cannot be written");
    }
    if (!file) fail(path, "cannot be written");
    try {
        write_and_close(std::move(file), path, bytes);
        if (fs::exists(status)) fs::permissions(temporary, status.permissions(), error);
        fs::rename(temporary, target, error);
        if (error) throw FileError(shown_path(path), "", "cannot be written (" + error.message() + ")");
    } catch (...) {
        fs::remove(temporary, error);
        throw;
    }
}

}  // namespace surflux
