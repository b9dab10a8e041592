#include "surflux/lights/photometric_web.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/sampling.h"
#include "surflux/lights/polygon.h"

namespace surflux {

namespace {

constexpr double degree = pi / 180.0;
// Pieces of a triangle whose light is told by their middles: half the spacing of the table, within these bounds.
constexpr double widest_piece = 5.0 * degree, least_piece = 0.5 * degree;
constexpr int most_halvings = 40;
constexpr int rings = 720, ring_turns = 24, ring_angles = 3;

struct Between {
    std::size_t low;
    double part;
};

// Where a value lies among ascending ones, whose ends hold it.
Between between(const std::vector<double>& values, double at) {
    const auto above = std::upper_bound(values.begin() + 1, values.end() - 1, at);
    const auto high = static_cast<std::size_t>(above - values.begin());
    return {high - 1, std::clamp((at - values[high - 1]) / (values[high] - values[high - 1]), 0.0, 1.0)};
}

// The integral of sine times what is linear between two angles (radians), where it has these values.
double ring_integral(double from, double to, double first, double last) {
    const double slope = (last - first) / (to - from);
    return first * std::cos(from) - last * std::cos(to) + slope * (std::sin(to) - std::sin(from));
}

}  // namespace

PhotometricWeb::PhotometricWeb(const PhotometricLight& light)
    : axis_(light.direction),
      zero_(light.zero_plane),
      quarter_(cross(light.zero_plane, light.direction)),
      planes_(light.planes),
      angles_(light.angles),
      table_(light.table) {
    double largest = 0.0, spacing = widest_piece / degree;
    for (const double share : table_) largest = std::max(largest, share);
    for (const std::vector<double>* values : {&planes_, &angles_})
        for (std::size_t k = 1; k < values->size(); ++k)
            spacing = std::min(spacing, 0.5 * ((*values)[k] - (*values)[k - 1]));
    step_ = std::clamp(spacing * degree, least_piece, widest_piece);
    const std::size_t n = angles_.size();
    for (std::size_t p = 1; p < planes_.size(); ++p)
        for (std::size_t k = 1; k < n; ++k)
            for (const std::size_t at : {p - 1, p})
                power_ += 0.5 * (planes_[p] - planes_[p - 1]) * degree *
                          ring_integral(angles_[k - 1] * degree, angles_[k] * degree, table_[at * n + k - 1],
                                        table_[at * n + k]);
    if (largest > 0.0) beam_ = std::acos(std::clamp(1.0 - power_ / (2.0 * pi * largest), -1.0, 1.0));
}

double PhotometricWeb::share(const Vec3& d) const {
    const double angle = std::atan2(length(cross(d, axis_)), dot(d, axis_)) / degree;
    if (angle < angles_.front() || angle > angles_.back()) return 0.0;
    double turn = std::atan2(dot(d, quarter_), dot(d, zero_)) / degree;
    if (turn < 0.0) turn += 360.0;
    const Between plane = between(planes_, turn), row = between(angles_, angle);
    const double* low = &table_[plane.low * angles_.size() + row.low];
    const double* high = low + angles_.size();
    const double first = low[0] + row.part * (low[1] - low[0]), last = high[0] + row.part * (high[1] - high[0]);
    return first + plane.part * (last - first);
}

double PhotometricWeb::power(const Vec3& from, const Triangle& t) const {
    return power({t.a - from, t.b - from, t.c - from}, most_halvings);
}

double PhotometricWeb::power(const Vec3 (&corners)[3], int depth) const {
    Vec3 unit[3];
    double far[3];
    for (int k = 0; k < 3; ++k) {
        far[k] = length(corners[k]);
        if (!(far[k] > 0.0)) return 0.0;  // it lies in the triangle's plane
        unit[k] = corners[k] / far[k];
    }
    int longest = 0;
    double widest = -1.0;
    for (int k = 0; k < 3; ++k) {
        const double apart = length_squared(unit[(k + 1) % 3] - unit[k]);
        if (apart > widest) widest = apart, longest = k;
    }
    if (depth == 0 || widest < step_ * step_) {
        const double angle = solid_angle({}, {corners[0], corners[1], corners[2], 0});
        return angle > 0.0 ? angle * share(unit[0] + unit[1] + unit[2]) : 0.0;
    }
    // Where half the angle of the longest side is.
    const int a = longest, b = (longest + 1) % 3, c = (longest + 2) % 3;
    const Vec3 middle = corners[a] + far[a] / (far[a] + far[b]) * (corners[b] - corners[a]);
    return power({corners[a], middle, corners[c]}, depth - 1) + power({middle, corners[b], corners[c]}, depth - 1);
}

Vec3 PhotometricWeb::along(double cosine, double turn) const {
    const double across = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    return cosine * axis_ + across * (std::cos(turn) * zero_ + std::sin(turn) * quarter_);
}

// Rings of equal angle. What lies between the directions that are asked is small beside the ring's, or nothing.
PhotometricWeb::Rays::Rays(const PhotometricWeb& web) : web_(web) {
    double sum = 0.0;
    for (int k = 0; k < rings; ++k) {
        double mean = 0.0;
        for (int a = 0; a < ring_angles; ++a)
            for (int t = 0; t < ring_turns; ++t) {
                const double angle = (k + (a + 0.5) / ring_angles) * pi / rings;
                mean += web.share(web.along(std::cos(angle), 2.0 * pi * (t + 0.5) / ring_turns));
            }
        const double from = k * pi / rings, to = (k + 1) * pi / rings;
        up_to_.push_back(sum += mean * (std::cos(from) - std::cos(to)));
    }
    for (double& share : up_to_) share = sum > 0.0 ? share / sum : 1.0;
}

std::pair<Vec3, double> PhotometricWeb::Rays::draw(double u, double v) const {
    const auto found = std::upper_bound(up_to_.begin(), up_to_.end() - 1, u);
    const double below = found == up_to_.begin() ? 0.0 : found[-1], own = *found - below;
    if (!(own > 0.0)) return {web_.axis_, 0.0};
    const auto ring = static_cast<double>(found - up_to_.begin());
    const double from = std::cos(ring * pi / rings), to = std::cos((ring + 1.0) * pi / rings);
    const Vec3 d = web_.along(from + (u - below) / own * (to - from), 2.0 * pi * v);
    return {d, web_.share(d) * (from - to) / own};
}

}  // namespace surflux
