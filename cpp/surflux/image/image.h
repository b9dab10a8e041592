#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace surflux {

// Linear float pixels, rows from the top: pixels[(y * width + x) * channels.size() + c].
// Channel names are those of EXR: R G B A, Y for grey, Z for depth, layer.R and so on for a layer.
struct Image {
    std::size_t width = 0, height = 0;
    std::vector<std::string> channels;
    std::vector<float> pixels;
};

// Reads .exr, .hdr and .png (sRGB made linear), first image of the file. Throws FileError.
Image read_image(const std::string& path);

// Writes .exr (32-bit float, any channels), .hdr (R G B) and .png (8 bit, clamped to 0..1, sRGB; R G B, R G B A or Y).
// The file appears whole or not at all. Throws FileError, and ArgumentError for channels that the format has no place
// for.
void write_image(const std::string& path, const Image& image);

// OpenImageIO's, as it was compiled against.
std::string image_library_version();

}  // namespace surflux
