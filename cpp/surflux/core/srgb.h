#pragma once

#include <cmath>

namespace surflux {

// The sRGB transfer function (IEC 61966-2-1), between linear and encoded values in 0..1.
inline double srgb_encode(double linear) {
    if (!(linear > 0.0)) return 0.0;  // NaN too
    if (linear >= 1.0) return 1.0;
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

inline double srgb_decode(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

}  // namespace surflux
