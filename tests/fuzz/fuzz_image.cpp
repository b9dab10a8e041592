#include <filesystem>
#include <fstream>

#include <unistd.h>

#include "fuzz.h"
#include "surflux/image/image.h"

namespace surflux::fuzz {
namespace {

// Pictures are read by name; script/fuzz names a folder in memory.
std::string path_of_input() {
    namespace fs = std::filesystem;
    const char* folder = std::getenv("SURFLUX_FUZZ_FOLDER");
    const std::string name = "surflux-fuzz-" + std::to_string(getpid()) + SURFLUX_SUFFIX;
    return ((folder ? fs::path(folder) : fs::temp_directory_path()) / name).string();
}

struct InputFile {
    std::string path = path_of_input();
    ~InputFile() { std::remove(path.c_str()); }
};

}  // namespace
}  // namespace surflux::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace surflux;
    static const fuzz::InputFile file;
    std::ofstream(file.path, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    fuzz::accepted_or_refused(file.path, [&] {
        const Image image = read_image(file.path);
        fuzz::hold(image.width > 0 && image.height > 0 && !image.channels.empty(), "a picture has pixels");
        fuzz::hold(image.pixels.size() == image.width * image.height * image.channels.size(), "all of its pixels");
    });
    return 0;
}
