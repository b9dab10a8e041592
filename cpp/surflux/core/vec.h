#pragma once

#include <algorithm>
#include <cmath>

namespace surflux {

// Three doubles: a position, a direction, or linear RGB. Plain data, so that arrays of it are arrays of doubles.
struct Vec3 {
    double x = 0.0, y = 0.0, z = 0.0;

    double& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
    const double& operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
    Vec3& operator+=(const Vec3& b) { return x += b.x, y += b.y, z += b.z, *this; }
    Vec3& operator-=(const Vec3& b) { return x -= b.x, y -= b.y, z -= b.z, *this; }
    Vec3& operator*=(double s) { return x *= s, y *= s, z *= s, *this; }
};

using Rgb = Vec3;

inline Vec3 operator+(Vec3 a, const Vec3& b) { return a += b; }
inline Vec3 operator-(Vec3 a, const Vec3& b) { return a -= b; }
inline Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(Vec3 a, double s) { return a *= s; }
inline Vec3 operator*(double s, Vec3 a) { return a *= s; }
inline Vec3 operator/(Vec3 a, double s) { return a *= 1.0 / s; }
inline Vec3 operator*(const Vec3& a, const Vec3& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline bool operator==(const Vec3& a, const Vec3& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length_squared(const Vec3& a) { return dot(a, a); }
inline double length(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline Vec3 normalized(const Vec3& a) { return a / length(a); }
inline bool is_finite(const Vec3& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

// Of linear Rec. 709.
inline double luminance(const Rgb& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

// How much there is of a colour, or of a difference of two, which of colours of one luminance is not 0: RMS of the
// channels, with the weights of luminance. Of grey it is the luminance.
inline double color_norm(const Rgb& c) {
    return std::sqrt(0.2126 * c.x * c.x + 0.7152 * c.y * c.y + 0.0722 * c.z * c.z);
}

inline double largest_channel(const Rgb& c) { return std::max({c.x, c.y, c.z}); }

struct Frame {
    Vec3 u, v, n;
    Vec3 to_world(const Vec3& local) const { return local.x * u + local.y * v + local.z * n; }
};

// Right-handed orthonormal frame around a unit normal (Duff et al., JCGT 6(1), 2017): no branch near the poles.
inline Frame frame_around(const Vec3& n) {
    const double sign = std::copysign(1.0, n.z);
    const double a = -1.0 / (sign + n.z);
    const double b = n.x * n.y * a;
    return {{1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

}  // namespace surflux
