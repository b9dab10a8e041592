#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "surflux/core/error.h"
#include "surflux/core/srgb.h"
#include "surflux/image/image.h"

namespace surflux {
namespace {

namespace fs = std::filesystem;

class ImageFiles : public testing::Test {
protected:
    ImageFiles() : folder_(fs::temp_directory_path() / ("surflux-image-" + std::to_string(getpid()))) {
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    ~ImageFiles() override { fs::remove_all(folder_); }

    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    std::size_t files() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
    }
    void put(const std::string& name, const std::string& bytes) const {
        std::ofstream(path(name), std::ios::binary) << bytes;
    }
    std::string get(const std::string& name) const {
        std::ifstream in(path(name), std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }

    fs::path folder_;
};

Image ramp(std::size_t width, std::size_t height, std::vector<std::string> channels) {
    Image image{width, height, std::move(channels), {}};
    for (std::size_t i = 0; i < width * height * image.channels.size(); ++i) {
        image.pixels.push_back(static_cast<float>(i) / static_cast<float>(width * height * image.channels.size()));
    }
    return image;
}

void expect_file_error(const std::function<void()>& action, const std::string& path, const std::string& reason) {
    try {
        action();
        ADD_FAILURE() << path << ": no error";
    } catch (const FileError& error) {
        const std::string text = error.what();
        EXPECT_EQ(text.rfind(path, 0), 0u) << text;
        EXPECT_NE(text.find(reason), std::string::npos) << text;
    }
}

TEST_F(ImageFiles, ExrKeepsEveryFloatOfEveryLayer) {
    Image image = ramp(7, 5, {"R", "G", "B", "Z", "indirect.R", "indirect.G", "indirect.B"});
    image.pixels[3] = std::numeric_limits<float>::infinity();  // depth where nothing is seen
    image.pixels[7] = 1e30f;
    image.pixels[8] = -0.1f;
    write_image(path("a.exr"), image);
    const Image back = read_image(path("a.exr"));
    ASSERT_EQ(back.width, 7u);
    ASSERT_EQ(back.height, 5u);
    ASSERT_EQ(back.channels.size(), image.channels.size());
    for (std::size_t c = 0; c < image.channels.size(); ++c) {  // a reader may order channels as it likes
        const auto at = static_cast<std::size_t>(
            std::find(back.channels.begin(), back.channels.end(), image.channels[c]) - back.channels.begin());
        ASSERT_LT(at, back.channels.size()) << image.channels[c];
        for (std::size_t p = 0; p < 35; ++p) ASSERT_EQ(back.pixels[p * 7 + at], image.pixels[p * 7 + c]);
    }
}

// RGBE holds 8 bits of mantissa below the largest channel: an error of at most 2^-8 of that, up to the truncation.
TEST_F(ImageFiles, HdrKeepsEightBitsOfMantissa) {
    Image image = ramp(16, 9, {"R", "G", "B"});
    for (float& v : image.pixels) v *= 5000.0f;
    write_image(path("a.hdr"), image);
    const Image back = read_image(path("a.hdr"));
    ASSERT_EQ(back.pixels.size(), image.pixels.size());
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const std::size_t first = i / 3 * 3;
        const float largest = std::max({image.pixels[first], image.pixels[first + 1], image.pixels[first + 2]});
        ASSERT_NEAR(back.pixels[i], image.pixels[i], largest / 128.0f);
    }
}

// 8 bits of sRGB: half a step, 0.5/255, through the curve's steepest slope when decoded, 2.4/1.055 = 2.275.
TEST_F(ImageFiles, PngIsLinearAgainAfterReading) {
    for (const std::vector<std::string>& channels :
         {std::vector<std::string>{"R", "G", "B"}, {"R", "G", "B", "A"}, {"Y"}}) {
        const Image image = ramp(32, 8, channels);
        write_image(path("a.png"), image);
        const Image back = read_image(path("a.png"));
        ASSERT_EQ(back.channels, channels);
        for (std::size_t i = 0; i < image.pixels.size(); ++i) {
            ASSERT_NEAR(back.pixels[i], image.pixels[i], 2.275 * 0.5 / 255.0 + 1e-6)
                << "channel " << i % channels.size();
        }
    }
}

TEST_F(ImageFiles, PngClampsWhatADisplayCannotShow) {
    write_image(path("a.png"), {1, 1, {"R", "G", "B"}, {7.0f, -1.0f, std::nanf("")}});
    EXPECT_EQ(read_image(path("a.png")).pixels, (std::vector<float>{1.0f, 0.0f, 0.0f}));
}

TEST(Srgb, KnownValuesAndInverse) {
    EXPECT_NEAR(srgb_encode(0.5), 0.735357, 1e-6);  // IEC 61966-2-1
    EXPECT_NEAR(srgb_decode(0.5), 0.214041, 1e-6);
    for (double x = 0.0; x <= 1.0; x += 0.01) EXPECT_NEAR(srgb_decode(srgb_encode(x)), x, 1e-6);
}

TEST_F(ImageFiles, RefusesWhatItCannotRead) {
    expect_file_error([&] { read_image(path("none.exr")); }, path("none.exr"), "no such file");
    expect_file_error([&] { read_image(path("a.jpg")); }, path("a.jpg"), ".exr, .hdr and .png are supported");
    expect_file_error([&] { read_image(path("noname")); }, path("noname"), ".exr, .hdr and .png are supported");
    fs::create_directory(path("folder.png"));
    expect_file_error([&] { read_image(path("folder.png")); }, path("folder.png"), "is a folder, not a file");
}

TEST_F(ImageFiles, BrokenContentIsAFileErrorAndNothingElse) {
    for (const std::string suffix : {"exr", "hdr", "png"}) {
        const std::string name = "a." + suffix;
        put(name, "");
        expect_file_error([&] { read_image(path(name)); }, path(name), ": ");
        put(name, "this is no image, whatever its name says");
        expect_file_error([&] { read_image(path(name)); }, path(name), ": ");
        // One format under the name of another: nothing is detected.
        write_image(path(name), ramp(64, 64, {"R", "G", "B"}));
        const std::string whole = get(name);
        for (const std::string other : {"exr", "hdr", "png"}) {
            if (other == suffix) continue;
            put("b." + other, whole);
            expect_file_error([&] { read_image(path("b." + other)); }, path("b." + other), ": ");
        }
        for (const std::size_t part : {10ul, whole.size() / 2, whole.size() * 9 / 10}) {
            put(name, whole.substr(0, part));
            expect_file_error([&] { read_image(path(name)); }, path(name), ": ");
        }
        // Any byte of the header may be wrong: an image or a FileError, no crash, no endless allocation.
        for (std::size_t at = 0; at < 200; ++at) {
            std::string bytes = whole;
            bytes[at] = static_cast<char>(bytes[at] ^ 0x5a);
            put(name, bytes);
            try {
                read_image(path(name));
            } catch (const FileError&) {
            }
        }
    }
}

TEST_F(ImageFiles, ABrokenPngSaysWhere) {
    write_image(path("a.png"), ramp(8, 8, {"R", "G", "B"}));
    const std::string whole = get("a.png");
    put("a.png", "GIF89a, no PNG");
    expect_file_error([&] { read_image(path("a.png")); }, path("a.png"), "(byte 0): not a PNG file");
    put("a.png", whole.substr(0, 20));  // within the first chunk, which starts behind the signature of 8 bytes
    expect_file_error([&] { read_image(path("a.png")); }, path("a.png"), "(byte 8): the file ends early");
    put("a.png", whole.substr(0, whole.size() - 12));  // without IEND
    expect_file_error([&] { read_image(path("a.png")); }, path("a.png"),
                      "(byte " + std::to_string(whole.size() - 12) + "): the file ends early");
}

TEST_F(ImageFiles, AHugeClaimIsRefusedBeforeAnythingIsAllocated) {
    put("a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n1234");
    expect_file_error([&] { read_image(path("a.hdr")); }, path("a.hdr"), "claims 60000 x 60000 pixels");
    // One line, of which OpenImageIO makes room for 256.
    put("a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 496721\n" + std::string(80, '1'));
    expect_file_error([&] { read_image(path("a.hdr")); }, path("a.hdr"), "claims 496721 x 256 pixels");
}

// What script/fuzz found: OpenEXR believes every size in a header, and asks for as much memory.
TEST_F(ImageFiles, AnExrHeaderIsHeldAgainstItsFile) {
    write_image(path("a.exr"), ramp(4, 4, {"R", "G", "B"}));
    const std::string whole = get("a.exr");
    const auto refused = [&](const std::string& after, const std::string& bytes, const std::string& reason) {
        std::string broken = whole;
        const std::size_t at = broken.find(after);
        ASSERT_NE(at, std::string::npos) << after;
        SCOPED_TRACE(reason);
        broken.replace(at + after.size(), bytes.size(), bytes);
        put("b.exr", broken);
        expect_file_error([&] { read_image(path("b.exr")); }, path("b.exr"), reason);
    };
    using std::string_literals::operator""s;
    refused("", "nothing", "(byte 0): not an EXR file");
    // An attribute of unknown type is kept whole, whatever it says its size is.
    refused("capDate\0"s, "strinh\0\x13\0\x03\x64"s, "the attribute 'capDate' claims 1677918227 bytes, but ");
    // One of a known type is read by that, and the file is out of step from then on.
    refused("dataWindow\0box2i\0"s, "\x0c"s, "the attribute 'dataWindow' has 12 bytes; wanted 16 of type box2i");
    refused("dataWindow\0box2i\0\x10\0\0\0"s, "\0\0\0\0\0\0\0\0\xff\xff\xff\x7f\x01\0\0\0"s,
            "claims 2147483648 x 2 pixels of 3 channels, more than its ");
    refused("dataWindow\0box2i\0\x10\0\0\0"s, "\x01\0\0\0\0\0\0\0\0\0\0\0"s, "an image without pixels");
    // Lines that are unpacked together may be more than the picture has.
    refused("dataWindow\0box2i\0\x10\0\0\0"s, "\0\0\0\0\0\0\0\0\0\0\x20\0\0\0\0\0"s,
            "claims 2097153 x 256 pixels of 3 channels, more than its ");
    refused("channels\0chlist\0"s, "\x30"s, "the list of channels does not end where its attribute does");
    // 16 bytes of the next attribute, as texts: one of -1 bytes, one that is longer than the attribute.
    refused("dataWindow\0"s, "stringvector\0\x04\0\0\0\xff\xff\xff\xff"s, "a text of negative length");
    refused("dataWindow\0"s, "stringvector\0\x04\0\0\0\x01\0\0\0"s,
            "a list of texts does not end where its attribute does");
    refused("dataWindow\0"s, "preview\0\x08\0\0\0\xff\xff\0\0\xff\xff\0\0"s,
            "the preview claims another size than its attribute");
    refused("dataWindow\0"s, std::string(300, 'x'), "a name of more than 255 letters");
    put("b.exr", whole.substr(0, 60));
    expect_file_error([&] { read_image(path("b.exr")); }, path("b.exr"), "the file ends early");
}

TEST_F(ImageFiles, AFailedWriteLeavesNothing) {
    const Image image = ramp(4, 4, {"R", "G", "B"});
    expect_file_error([&] { write_image(path("a.tif"), image); }, path("a.tif"), ".exr, .hdr and .png are supported");
    expect_file_error([&] { write_image(path("no/a.exr"), image); }, path("no/a.exr"),
                      "cannot be written: there is no folder " + path("no"));
    EXPECT_EQ(files(), 0u);
    fs::create_directory(path("a.exr"));
    expect_file_error([&] { write_image(path("a.exr"), image); }, path("a.exr"), "is a folder, not a file");
    EXPECT_EQ(files(), 1u);
}

TEST_F(ImageFiles, WritesThroughALinkAndReplacesWhatIsThere) {
    write_image(path("a.exr"), ramp(4, 4, {"R", "G", "B"}));
    fs::create_symlink(path("a.exr"), path("link.exr"));
    write_image(path("link.exr"), ramp(2, 2, {"R", "G", "B"}));
    EXPECT_TRUE(fs::is_symlink(path("link.exr")));
    EXPECT_EQ(read_image(path("a.exr")).width, 2u);
    EXPECT_EQ(files(), 2u);
}

TEST_F(ImageFiles, RefusesChannelsThatTheFormatHasNoPlaceFor) {
    EXPECT_THROW(write_image(path("a.hdr"), ramp(2, 2, {"R", "G", "B", "Z"})), ArgumentError);
    EXPECT_THROW(write_image(path("a.png"), ramp(2, 2, {"R", "G", "B", "Z"})), ArgumentError);
    EXPECT_THROW(write_image(path("a.exr"), ramp(2, 2, {"R", "R"})), ArgumentError);
    EXPECT_THROW(write_image(path("a.exr"), {2, 2, {"R"}, {1.0f}}), ArgumentError);
    EXPECT_EQ(files(), 0u);
}

}  // namespace
}  // namespace surflux
