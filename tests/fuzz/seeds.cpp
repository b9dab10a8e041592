// Writes what the fuzzers begin with, by our own writers where there is one: fuzz_seeds FOLDER makes FOLDER/ply and so
// on.

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "surflux/files/ply.h"
#include "surflux/image/image.h"

namespace surflux {
namespace {

namespace fs = std::filesystem;

void put(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

std::string get(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

PlyElement element(const std::string& name, std::size_t rows, const std::vector<std::string>& columns, PlyType type) {
    PlyElement out{name, rows, {}};
    for (const std::string& column : columns) {
        out.columns.push_back({column, type, {}});
        for (std::size_t i = 0; i < rows; ++i) out.columns.back().values.push_back(i % 2 == 0 ? 0.0 : 1.0);
    }
    return out;
}

void ply_seeds(const fs::path& folder) {
    const std::vector<std::string> xyz{"x", "y", "z"};
    Polygons faces;
    faces.corners = {0, 1, 2, 0, 2, 3, 1};
    faces.begin = {0, 3, 7};
    write_ply((folder / "mesh").string(), {element("vertex", 4, xyz, PlyType::float32), element("face", 2, {}, {})},
              faces, {"made by hand"});
    // A cloud with everything that surflux writes, patches and a description of a solution.
    PlyElement cloud = element("vertex", 3, xyz, PlyType::float64);
    for (const char* name : {"nx", "ny", "nz", "radius", "area", "reflectance_r", "radiosity_r", "parent"})
        cloud.columns.push_back({name, PlyType::float32, {0.25, 0.5, 0.75}});
    cloud.columns.push_back({"red", PlyType::uint8, {0.0, 127.0, 255.0}});
    PlyElement patch = element("patch", 2, {"surfel"}, PlyType::uint8);
    for (const char* name : {"x0", "y0", "z0", "x1", "y1", "z1", "x2", "y2", "z2"})
        patch.columns.push_back({name, PlyType::float64, {0.0, 1.0}});
    write_ply((folder / "cloud").string(), {cloud, patch}, {}, {"surflux {\"solution\":1,\"error\":null}"});
    put(folder / "ascii",
        "ply\nformat ascii 1.0\ncomment c\nobj_info o\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property double z\nproperty list uchar int extra\nelement face 1\nproperty list uchar int vertex_indices\n"
        "end_header\n0 0 .5 0\n1.5 0 -2e1 1 7\n0 1 +3 2 -1 1\n3 0 1 2\n");
    put(folder / "big",
        std::string("ply\r\nformat binary_big_endian 1.0\r\nelement vertex 2\r\nproperty short x\r\nproperty uint y\r\n"
                    "property list int char l\r\nproperty float z\r\nend_header\r\n") +
            std::string("\0\1\0\0\0\2\0\0\0\1\7\0\0\0\0", 15) + std::string("\0\1\0\0\0\2\0\0\0\0\0\0\0\0", 14));
    put(folder / "returns", "ply\rformat ascii 1.0\relement vertex 1\rproperty int8 x\rend_header\r-7\r");
}

void obj_seeds(const fs::path& folder) {
    put(folder / "mesh",
        "# two faces\nmtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1e0 0 1\nvt 0 0\nvn 0 0 1\nf 1 2 3 4\nf -1//1 -2/1 "
        "\\\n-3\n");
    put(folder / "colors", "f 1/1/1 2/2/2 3\nv 0 0 0 .1 .2 .3\nv -1 2. 0 1 1 1\nv +1 nan_ 0\n");
    put(folder / "colored", "v 0 0 0 .1 .2 .3\r\nv -1 2. 0 1 1 1\r\nv 3 0 0 0 0 0\r\nf 1 2 3 # face\r\no end");
}

void image_seeds(const fs::path& folder) {
    const auto picture = [](std::size_t width, std::size_t height, std::vector<std::string> channels) {
        Image image{width, height, std::move(channels), {}};
        for (std::size_t i = 0; i < width * height * image.channels.size(); ++i)
            image.pixels.push_back(std::exp(-0.3f * static_cast<float>(i % 17)));
        return image;
    };
    const std::vector<std::string> rgb{"R", "G", "B"};
    for (const std::string format : {"exr", "hdr", "png"}) {
        const auto save = [&](const std::string& name, const Image& image) {
            const fs::path path = folder / format / (name + "." + format);
            write_image(path.string(), image);
            fs::rename(path, folder / format / name);
        };
        save("one", picture(1, 1, rgb));
        save("wide", picture(16, 3, rgb));
        if (format == "exr") save("layers", picture(5, 4, {"R", "G", "B", "Z", "indirect.R"}));
        if (format == "png") save("grey", picture(9, 2, {"Y"}));
        if (format == "png") save("alpha", picture(3, 3, {"R", "G", "B", "A"}));
        const std::string whole = get(folder / format / "wide");
        put(folder / format / "cut", whole.substr(0, whole.size() - 9));
    }
}

}  // namespace
}  // namespace surflux

int main(int count, char** arguments) {
    if (count != 2) {
        std::cerr << "usage: fuzz_seeds FOLDER\n";
        return 2;
    }
    const surflux::fs::path folder = arguments[1];
    for (const char* name : {"ply", "obj", "exr", "hdr", "png"}) surflux::fs::create_directories(folder / name);
    surflux::ply_seeds(folder / "ply");
    surflux::obj_seeds(folder / "obj");
    surflux::image_seeds(folder);
    return 0;
}
