#include "surflux/render/tone_map.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"

namespace surflux {

namespace {

// Straight up to `knee`, then bent towards 1 with a continuous slope: middle tones keep their contrast and hue.
double shoulder(double x) {
    constexpr double knee = 0.6;
    return x <= knee ? x : 1.0 - (1.0 - knee) * std::exp(-(x - knee) / (1.0 - knee));
}

// The sorted values without the runs of equal ones that are longer than a hundredth of them all.
std::vector<double> without_plateaus(const std::vector<double>& sorted) {
    std::vector<double> rest;
    for (std::size_t begin = 0, end = 0; begin < sorted.size(); begin = end) {
        while (end < sorted.size() && sorted[end] == sorted[begin]) ++end;
        if (100 * (end - begin) <= sorted.size()) rest.insert(rest.end(), end - begin, sorted[begin]);
    }
    return rest;
}

}  // namespace

double automatic_exposure(const std::vector<float>& rgb) {
    std::vector<double> luminance;
    luminance.reserve(rgb.size() / 3);
    for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
        // Rec. 709.
        const double y = 0.2126 * static_cast<double>(rgb[i]) + 0.7152 * static_cast<double>(rgb[i + 1]) +
                         0.0722 * static_cast<double>(rgb[i + 2]);
        if (std::isfinite(y) && y > 0.0) luminance.push_back(y);
    }
    if (luminance.empty()) return 1.0;
    std::sort(luminance.begin(), luminance.end());
    // A picture of flat colours alone, or of few pixels, is all plateaus.
    if (std::vector<double> rest = without_plateaus(luminance); !rest.empty()) luminance = std::move(rest);
    const std::size_t cut = luminance.size() / 50;
    double sum = 0.0;
    for (std::size_t i = cut; i < luminance.size() - cut; ++i) sum += std::log(luminance[i]);
    return 0.22 / std::exp(sum / static_cast<double>(luminance.size() - 2 * cut));
}

std::vector<float> tone_map(const std::vector<float>& rgb, const ToneMapOptions& options) {
    require(rgb.size() % 3 == 0, "image: wanted 3 values per pixel");
    require(!options.exposure || (std::isfinite(*options.exposure) && *options.exposure > 0.0),
            "exposure: wanted a positive number");
    const double exposure = options.exposure ? *options.exposure : automatic_exposure(rgb);
    std::vector<float> display(rgb.size());
    for (std::size_t i = 0; i < rgb.size(); ++i) {
        const double x = exposure * static_cast<double>(rgb[i]);
        if (!(x > 0.0)) continue;  // NaN too
        display[i] = static_cast<float>(options.filmic ? shoulder(x) : std::min(x, 1.0));
    }
    return display;
}

}  // namespace surflux
