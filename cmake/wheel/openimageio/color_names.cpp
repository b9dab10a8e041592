// What the readers and writers of EXR, HDR and PNG ask of OpenImageIO's ColorConfig, without OpenColorIO: names of
// colour spaces are put down as files say, and no pixel is converted.
#include <cmath>

#include <OpenImageIO/color.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>

#include "imageio_pvt.h"

OIIO_NAMESPACE_3_1_BEGIN

class ColorConfig::Impl {};

ColorConfig::ColorConfig(string_view) {}
ColorConfig::~ColorConfig() {}

const ColorConfig& ColorConfig::default_colorconfig() {
    static const ColorConfig config;
    return config;
}

int ColorConfig::OpenColorIO_version_hex() { return 0; }

void ColorConfig::set_colorspace(ImageSpec& spec, string_view name) const {
    if (name.empty())
        spec.erase_attribute("oiio:ColorSpace");
    else
        spec.attribute("oiio:ColorSpace", name);
}

// An interop ID is a registered name: none is made up for another one.
string_view ColorConfig::get_color_interop_id(string_view name) const {
    return Strutil::ends_with(name, "_scene") || Strutil::ends_with(name, "_display") ? name : string_view();
}

void set_colorspace_rec709_gamma(ImageSpec& spec, float gamma) {
    if (std::abs(gamma - 1.0f) <= 0.01f) {
        spec.set_colorspace("lin_rec709_scene");
    } else {
        spec.set_colorspace(Strutil::fmt::format("g{}_rec709_scene", std::lround(gamma * 10.0f)));
        spec.attribute("oiio:Gamma", gamma);
    }
}

bool is_colorspace_srgb(const ImageSpec& spec, bool unnamed) {
    const string_view name = spec.get_string_attribute("oiio:ColorSpace");
    return name.empty() ? unnamed : Strutil::istarts_with(name, "srgb");
}

std::vector<uint8_t> get_colorspace_icc_profile(const ImageSpec& spec, bool) {
    const ParamValue* profile = spec.find_attribute("ICCProfile");
    if (!profile) return {};
    const cspan<uint8_t> bytes = profile->as_cspan<uint8_t>();
    return {bytes.begin(), bytes.end()};
}

OIIO_NAMESPACE_3_1_END

OIIO_NAMESPACE_BEGIN

float pvt::get_colorspace_rec709_gamma(const ImageSpec& spec) {
    if (spec.get_string_attribute("oiio:ColorSpace") == "lin_rec709_scene") return 1.0f;
    return spec.get_float_attribute("oiio:Gamma", 0.0f);
}

OIIO_NAMESPACE_END
