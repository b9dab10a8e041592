#pragma once

#include <string>

namespace surflux {

// What the header of a picture claims, held against the size of the file: a library believes it and asks for the
// memory. Each throws FileError.

// Pixels stored as floats: no format here packs them more than 100 000 times.
void check_pixel_claim(const std::string& path, double width, double height, double channels);

// The same for what is unpacked at once, which may be more than the picture: OpenEXR unpacks up to 256 lines together,
// and OpenImageIO makes room for as many. Up to 256 MB are free.
constexpr double lines_at_once = 256.0;
void check_chunk_claim(const std::string& path, double width, double height, double channels);

// Walks the attributes of an EXR file's headers: each whole, the picture no larger than the file can hold.
void check_exr(const std::string& path);

// What an HDR file's header says and OpenImageIO does not tell: pixels are radiance times `exposure` (all EXPOSURE and
// COLORCORR of it), and lines may run from the bottom up, or from right to left.
struct HdrHeader {
    double exposure[3] = {1.0, 1.0, 1.0};
    bool from_bottom = false, from_right = false;
};
// The size in the header is checked before OpenImageIO sees it, whose newer versions refuse large ones in words of
// their own. A header that cannot be told is left to OpenImageIO.
HdrHeader check_hdr(const std::string& path);

// Walks a PNG file's chunks: each whole, the last one IEND. OpenImageIO leaks memory where a file ends early.
void check_png(const std::string& path);

}  // namespace surflux
