#pragma once

// Small PLY files, and a folder to put them in.

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "surflux/core/error.h"
#include "surflux/files/ply.h"

namespace surflux {

namespace fs = std::filesystem;

// A folder of its own for each test, gone with it.
class Ply : public ::testing::Test {
protected:
    void SetUp() override {
        const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
        folder_ = fs::temp_directory_path() / ("surflux_ply_" + std::string(test->name()) + std::to_string(::getpid()));
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    std::string path(const std::string& name = "a.ply") const { return (folder_ / name).string(); }

    std::string file(const std::string& bytes, const std::string& name = "a.ply") const {
        std::ofstream(path(name), std::ios::binary) << bytes;
        return path(name);
    }

    PlyData read(const std::string& bytes) const { return parse_ply(path(), bytes); }

    // What the FileError says after the path; fails where there is none.
    std::string refusal(const std::string& bytes) const {
        try {
            (void)read(bytes);
        } catch (const FileError& e) {
            const std::string text = e.what();
            EXPECT_EQ(text.rfind(path(), 0), 0u) << text;
            return text.substr(path().size());
        }
        ADD_FAILURE() << "no FileError for:\n" << bytes;
        return "";
    }

    fs::path folder_;
};

template <class T>
void put(std::string& bytes, T value, bool big) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (big) std::reverse(raw, raw + sizeof(T));  // these tests run on little-endian machines
    bytes.append(raw, sizeof(T));
}

inline const std::vector<double>& column(const PlyData& data, const std::string& element, const std::string& name) {
    for (const PlyColumn& c : data.find(element)->columns)
        if (c.name == name) return c.values;
    throw std::out_of_range(name);
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
        text.replace(at, from.size(), to);
    return text;
}

inline const std::string triangle =
    "ply\nformat ascii 1.0\ncomment made by hand\nobj_info scanner 7\nelement vertex 3\nproperty float x\n"
    "property float y\nproperty double z\nproperty uchar red\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n0 0 .5 255\n1.5 0 -2e1 0\n0 1 +3 7\n3 0 1 2\n";

// Two vertices between elements nobody asked for, lists before and after x y z, a quad and a triangle.
inline std::string binary_file(bool big, const std::string& newline) {
    std::string h = "ply\nformat " + std::string(big ? "binary_big_endian" : "binary_little_endian") +
                    " 1.0\nelement junk 2\nproperty list ushort double d\nproperty char c\nelement face 2\n"
                    "property uchar flags\nproperty list uchar ushort vertex_index\nproperty list int float uv\n"
                    "element vertex 4\nproperty short z\nproperty list uint8 int16 extra\nproperty float64 x\n"
                    "property uint32 id\nproperty float32 y\nelement other 1\nproperty int a\nend_header\n";
    std::string b = replaced(h, "\n", newline);
    for (int row = 0; row < 2; ++row) {
        put(b, std::uint16_t(row), big);
        for (int i = 0; i < row; ++i) put(b, 1e300, big);
        put(b, std::int8_t(-1), big);
    }
    const std::vector<std::vector<std::uint16_t>> faces{{0, 1, 2, 3}, {3, 2, 1}};
    for (const auto& face : faces) {
        put(b, std::uint8_t(9), big);
        put(b, std::uint8_t(face.size()), big);
        for (const std::uint16_t corner : face) put(b, corner, big);
        put(b, std::int32_t(1), big);
        put(b, 0.5f, big);
    }
    for (int i = 0; i < 4; ++i) {
        put(b, std::int16_t(-300 - i), big);
        put(b, std::uint8_t(i), big);
        for (int k = 0; k < i; ++k) put(b, std::int16_t(k), big);
        put(b, 5e6 + 0.001 * i, big);
        put(b, std::uint32_t(4000000000u + std::uint32_t(i)), big);
        put(b, 0.25f * float(i), big);
    }
    put(b, std::int32_t(1), big);
    return b;
}

}  // namespace surflux
