#include "surflux/image/image.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <new>
#include <set>
#include <utility>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "surflux/core/error.h"
#include "surflux/core/file_bytes.h"
#include "surflux/core/srgb.h"
#include "surflux/image/claims.h"

namespace surflux {

namespace {

namespace fs = std::filesystem;

enum class Format { exr, hdr, png };

constexpr float hdr_limit = 0x1p127f;  // of values: exponents are a byte
constexpr float hdr_rounding = 1e-6f;  // of the largest: what is so little below 0 is 0

// By suffix from this list alone: OpenImageIO has readers for dozens of formats, some with known overflows, and must
// never guess among them.
Format format_of(const std::string& path) {
    std::string suffix = fs::path(path).extension().string();
    std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (suffix == ".exr") return Format::exr;
    if (suffix == ".hdr") return Format::hdr;
    if (suffix == ".png") return Format::png;
    throw FileError(path, "", "unknown image format '" + suffix + "'; .exr, .hdr and .png are supported");
}

const char* library_name(Format format) {
    return format == Format::exr ? "openexr" : format == Format::hdr ? "hdr" : "png";
}

// OpenEXR's threads are not in a process that was forked after they were started, and pictures would wait for them for
// ever: it has none (ahead of its first file).
void without_threads() {
    static const bool done = OIIO::attribute("exr_threads", -1);
    static_cast<void>(done);
}

std::string reason_or(std::string reason, const char* otherwise) {
    while (!reason.empty() && std::isspace(static_cast<unsigned char>(reason.back()))) reason.pop_back();
    return reason.empty() ? otherwise : reason;
}

// What is left to check once OpenImageIO has opened the file.
void check_claim(const std::string& path, const OIIO::ImageSpec& spec) {
    if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1) throw FileError(path, "", "an image without pixels");
    if (spec.deep) throw FileError(path, "", "a deep image; only flat ones are supported");
    if (spec.depth > 1) throw FileError(path, "", "a volume; only flat images are supported");
    check_pixel_claim(path, spec.width, spec.height, spec.nchannels);
    check_chunk_claim(path, spec.width, lines_at_once, spec.nchannels);
    if (spec.full_width < 1 || spec.full_height < 1) throw FileError(path, "", "a display window without pixels");
    check_chunk_claim(path, spec.full_width, spec.full_height, spec.nchannels);
}

void each_color(Image& image, double (*curve)(double)) {
    for (std::size_t c = 0; c < image.channels.size(); ++c) {
        if (image.channels[c] == "A") continue;
        for (std::size_t i = c; i < image.pixels.size(); i += image.channels.size()) {
            image.pixels[i] = static_cast<float>(curve(static_cast<double>(image.pixels[i])));
        }
    }
}

// A pixel of .hdr is three bytes and the exponent of the largest, which is 128 to 255: what was cut off when they were
// written is half of one in the mean, as Radiance has it (Ward 1991, Real Pixels). What is 0 stays so.
void add_halves(std::vector<float>& pixels) {
    for (std::size_t i = 0; i + 2 < pixels.size(); i += 3) {
        int exponent;
        std::frexp(std::max({pixels[i], pixels[i + 1], pixels[i + 2]}), &exponent);
        const float half = std::ldexp(1.0f, exponent - 9);
        for (std::size_t c = i; c < i + 3; ++c)
            if (pixels[c] > 0.0f) pixels[c] += half;
    }
}

// Radiance, and lines from the top, from left to right.
void undo(const HdrHeader& header, Image& image) {
    const std::size_t channels = image.channels.size(), line = image.width * channels;
    if (header.from_bottom)
        for (std::size_t y = 0; y < image.height / 2; ++y)
            std::swap_ranges(image.pixels.begin() + static_cast<std::ptrdiff_t>(y * line),
                             image.pixels.begin() + static_cast<std::ptrdiff_t>((y + 1) * line),
                             image.pixels.begin() + static_cast<std::ptrdiff_t>((image.height - 1 - y) * line));
    for (std::size_t y = 0; header.from_right && y < image.height; ++y)
        for (std::size_t x = 0; x < image.width / 2; ++x)
            for (std::size_t c = 0; c < channels; ++c)
                std::swap(image.pixels[y * line + x * channels + c],
                          image.pixels[y * line + (image.width - 1 - x) * channels + c]);
    if (channels == 3) add_halves(image.pixels);
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = static_cast<float>(static_cast<double>(image.pixels[i]) / header.exposure[i % channels]);
}

// The display window of an EXR picture, of which the file holds the data window: black where that is not, and without
// what of it lies outside.
Image displayed(Image image, const OIIO::ImageSpec& spec) {
    const std::int64_t left = std::int64_t{spec.x} - spec.full_x, top = std::int64_t{spec.y} - spec.full_y;
    if (left == 0 && top == 0 && spec.width == spec.full_width && spec.height == spec.full_height) return image;
    Image out;
    out.width = static_cast<std::size_t>(spec.full_width);
    out.height = static_cast<std::size_t>(spec.full_height);
    out.channels = image.channels;
    const auto channels = static_cast<std::int64_t>(image.channels.size());
    out.pixels.assign(out.width * out.height * image.channels.size(), 0.0f);
    const std::int64_t begin = std::max<std::int64_t>(0, left);
    const std::int64_t end = std::min<std::int64_t>(spec.full_width, left + spec.width);
    const std::int64_t bottom = std::min<std::int64_t>(spec.full_height, top + spec.height);
    for (std::int64_t y = std::max<std::int64_t>(0, top); begin < end && y < bottom; ++y)
        std::copy_n(image.pixels.begin() + ((y - top) * spec.width + begin - left) * channels, (end - begin) * channels,
                    out.pixels.begin() + (y * spec.full_width + begin) * channels);
    return out;
}

void check_channels(const Image& image, Format format) {
    require(image.width >= 1 && image.height >= 1 && !image.channels.empty() &&
                image.pixels.size() == image.width * image.height * image.channels.size(),
            "image: wanted width x height x channels values");
    std::set<std::string> names;
    for (const std::string& name : image.channels) {
        require(!name.empty() && names.insert(name).second, "channels: '", name, "' is empty or stands twice");
    }
    using Names = std::vector<std::string>;
    const bool rgb = image.channels == Names{"R", "G", "B"};
    require(
        format == Format::exr || rgb ||
            (format == Format::png && (image.channels == Names{"R", "G", "B", "A"} || image.channels == Names{"Y"})),
        "channels: ", format == Format::hdr ? ".hdr takes R G B" : ".png takes R G B, R G B A or Y",
        " alone; .exr takes any");
}

void check_target(const std::string& path) {
    require_folder(path);
    if (fs::exists(path) && !fs::is_regular_file(path)) throw FileError(path, "", "exists and is not a plain file");
}

}  // namespace

Image read_image(const std::string& path) try {
    const Format format = format_of(path);
    if (!fs::exists(path)) throw FileError(path, "", "no such file");
    if (fs::is_directory(path)) throw FileError(path, "", "is a folder, not a file");
    if (!fs::is_regular_file(path)) throw FileError(path, "", "not a plain file");
    if (format == Format::exr) check_exr(path);
    const HdrHeader hdr = format == Format::hdr ? check_hdr(path) : HdrHeader{};
    if (format == Format::png) check_png(path);
    without_threads();
    const auto input = OIIO::ImageInput::create(library_name(format));
    if (!input) throw FileError(path, "", reason_or(OIIO::geterror(), "OpenImageIO lacks this format"));
    OIIO::ImageSpec spec, options;
    options.attribute("oiio:UnassociatedAlpha", 1);  // else colours come multiplied by alpha, before the sRGB curve
    if (!input->open(path, spec, options)) throw FileError(path, "", reason_or(input->geterror(), "cannot be read"));
    check_claim(path, spec);
    for (const std::string& name : spec.channelnames)
        if (name == "RY" || name == "BY")
            throw FileError(path, "", "luminance and chroma (Y, RY, BY) are not supported; wanted R, G and B");
    Image image;
    image.width = static_cast<std::size_t>(spec.width);
    image.height = static_cast<std::size_t>(spec.height);
    image.channels = spec.channelnames;
    image.pixels.resize(image.width * image.height * image.channels.size());
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.pixels.data())) {
        throw FileError(path, "", reason_or(input->geterror(), "broken or incomplete"));
    }
    if (format == Format::png) each_color(image, srgb_decode);
    if (format == Format::hdr) undo(hdr, image);
    return format == Format::exr ? displayed(std::move(image), spec) : image;
} catch (const fs::filesystem_error& error) {
    throw FileError(path, "", error.code().message());
} catch (const std::bad_alloc&) {
    throw FileError(path, "", "does not fit into memory");
}

void write_image(const std::string& path, const Image& image) try {
    const Format format = format_of(path);
    check_channels(image, format);
    check_target(path);
    if (format == Format::hdr) {
        const float below = -hdr_rounding * *std::max_element(image.pixels.begin(), image.pixels.end());
        for (const float value : image.pixels)
            require(value >= below && value < hdr_limit, "image: .hdr takes values from 0 to 1.7e38, got ", value,
                    "; .exr takes any");
    }
    without_threads();
    const auto output = OIIO::ImageOutput::create(library_name(format));
    if (!output) throw FileError(path, "", reason_or(OIIO::geterror(), "OpenImageIO lacks this format"));
    OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height),
                         static_cast<int>(image.channels.size()),
                         format == Format::png ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT);
    spec.channelnames = image.channels;
    if (format == Format::png) {
        spec.attribute("oiio:ColorSpace", "sRGB");
        spec.attribute("oiio:UnassociatedAlpha", 1);
    }
    if (format == Format::exr) spec.attribute("compression", "zip");
    // Into memory, and from there at once: the PNG writer of OpenImageIO does not see that a disk is full.
    OIIO::Filesystem::IOVecOutput file;
    if (!output->set_ioproxy(&file)) throw FileError(path, "", "OpenImageIO cannot write this format into memory");
    if (!output->open(path, spec)) {
        throw FileError(path, "", reason_or(output->geterror(), "cannot be opened for writing"));
    }
    Image encoded;
    if (format != Format::exr) encoded = image;
    if (format == Format::png) each_color(encoded, srgb_encode);
    if (format == Format::hdr)
        for (float& value : encoded.pixels) value = std::max(0.0f, value);
    const std::vector<float>& pixels = format == Format::exr ? image.pixels : encoded.pixels;
    if (!output->write_image(OIIO::TypeDesc::FLOAT, pixels.data()) || !output->close()) {
        throw FileError(path, "", reason_or(output->geterror(), "cannot be written"));
    }
    write_bytes(path, {reinterpret_cast<const char*>(file.buffer().data()), file.buffer().size()});
} catch (const fs::filesystem_error& error) {
    throw FileError(path, "", error.code().message());
} catch (const std::bad_alloc&) {
    throw FileError(path, "", "does not fit into memory");
}

std::string image_library_version() { return OIIO_VERSION_STRING; }

}  // namespace surflux
