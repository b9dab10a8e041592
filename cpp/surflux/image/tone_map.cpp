#include "surflux/image/tone_map.h"

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

}  // namespace

double automatic_exposure(const std::vector<float>& rgb) {
    std::vector<double> logs;
    logs.reserve(rgb.size() / 3);
    for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
        // Rec. 709 luminance.
        const double y = 0.2126 * static_cast<double>(rgb[i]) + 0.7152 * static_cast<double>(rgb[i + 1]) +
                         0.0722 * static_cast<double>(rgb[i + 2]);
        if (std::isfinite(y) && y > 0.0) logs.push_back(std::log(y));
    }
    if (logs.empty()) return 1.0;
    std::sort(logs.begin(), logs.end());
    const std::size_t cut = logs.size() / 50;
    double sum = 0.0;
    for (std::size_t i = cut; i < logs.size() - cut; ++i) sum += logs[i];
    return 0.22 / std::exp(sum / static_cast<double>(logs.size() - 2 * cut));
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
