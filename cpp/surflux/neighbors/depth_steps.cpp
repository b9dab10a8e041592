#include "surflux/neighbors/depth_steps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr int half_widths[] = {3, 6, 12, 24, 48};  // of windows, in pixels
constexpr int across = 8;                          // samples from the middle of a window to its border, at most
// RMS, in steps, of what disparities are off planes. Where there is more, more are taken for one.
constexpr double usual_noise = 0.5;
constexpr double follows = 1.5;               // steps off a plane that a pixel of it is at most
constexpr double level_follows = 6.0;         // off a level plane, which knows no slope yet
constexpr double flat = 0.6;                  // RMS in steps of what is off a plane: rounding alone has .29
constexpr double bent = 0.36;                 // the same of a window that a crease or a border may go through
constexpr double some = 0.3, majority = 0.6;  // of the pixels of a window
constexpr int majority_half_width = 6;
// Of spots whose pixels are off alike, for neighbours share what their disparity is taken from.
constexpr int spot_half_width = 12;
constexpr double spot_follows = 2.5;  // steps off the plane around that their pixels are at most
// Of the pixels beyond so much of the window, those that follow the plane: a bar goes through, 3 pixels wide by .91.
constexpr double rim = 0.8, around_spots = 0.95;
constexpr std::size_t fewest_around = 20, fewest_alike = 4;
constexpr double deviations = 2.0;  // standard ones, of a confidence interval
// Each pass goes on from what the one before found, which is off planes by so much less than what was measured.
constexpr std::size_t passes = 3;
constexpr double later = 0.4;

struct Pixel {
    float u, v, disparity;  // x / |z|, y / |z|, and 1 / |z| over the step
};

// Of a window, in cells.
struct Shift {
    int x = 0, y = 0;
};

// Pixels by square cells, as large as a pixel is on average.
class Picture {
public:
    Picture(const std::vector<Vec3>& points, double step) : pixels_(points.size()) {
        std::array<std::vector<double>, 2> along;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3& p = points[i];
            const double depth = std::abs(p.z), at[2] = {p.x / depth, p.y / depth};
            pixels_[i] = {static_cast<float>(at[0]), static_cast<float>(at[1]),
                          static_cast<float>(1.0 / (depth * step))};
            measured_.push_back(pixels_[i].disparity);
            for (std::size_t axis = 0; axis < 2; ++axis) along[axis].push_back(at[axis]);
        }
        // What strays far off the picture has no say in its pixels.
        for (std::size_t axis = 0; axis < 2; ++axis) {
            const double low = quantile(along[axis], beyond), high = quantile(along[axis], 1.0 - beyond);
            low_[axis] = low - margin * (high - low);
            high_[axis] = high + margin * (high - low);
        }
        const auto count = static_cast<double>(points.size());
        side_ = std::sqrt(std::max(1e-300, (high_[0] - low_[0]) * (high_[1] - low_[1]) / count));
        // Where the picture has holes, pixels stand closer than they do on average.
        const double least = side_ / 4.0;
        for (int round = 0; round < 3; ++round)
            side_ = std::max(least, side_ * std::sqrt(static_cast<double>(count_cells()) / count));
        count_cells();
        for (std::size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
        order_.resize(points.size());
        std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
        for (std::uint32_t i = 0; i < points.size(); ++i) order_[next[cell_of(pixels_[i])]++] = i;
    }

    const Pixel& operator[](std::size_t i) const { return pixels_[i]; }
    double measured(std::size_t i) const { return static_cast<double>(measured_[i]); }
    double side() const { return side_; }
    // In multiples of so many steps from now on.
    void measure_in(double steps) {
        for (std::size_t i = 0; i < pixels_.size(); ++i)
            pixels_[i].disparity = measured_[i] /= static_cast<float>(steps);
    }
    void set(const std::vector<float>& disparities) {
        for (std::size_t i = 0; i < pixels_.size(); ++i) pixels_[i].disparity = disparities[i];
    }

    // Of the cells of a round window about a pixel, of some where it is wide, or of all, one pixel each.
    void around(std::size_t i, int half_width, const Shift& shift, std::vector<Pixel>& out, bool all = false) const {
        out.clear();
        const auto [own_x, own_y] = place_of(pixels_[i]);
        const int x = own_x + shift.x, y = own_y + shift.y;
        const int stride = all ? 1 : (half_width + across - 1) / across;
        // Of other cells for each pixel: no pattern of them shows.
        const std::uint32_t random = static_cast<std::uint32_t>(i) * 2654435761u;
        const int first_x = static_cast<int>((random >> 8) % static_cast<std::uint32_t>(stride)) - half_width,
                  first_y = static_cast<int>((random >> 20) % static_cast<std::uint32_t>(stride)) - half_width;
        for (int dy = first_y; dy <= half_width; dy += stride)
            for (int dx = first_x; dx <= half_width; dx += stride) {
                const int at_x = x + dx, at_y = y + dy;
                if (dx * dx + dy * dy > half_width * half_width || at_x < 0 || at_y < 0 || at_x >= size_[0] ||
                    at_y >= size_[1])
                    continue;
                const std::size_t c = index({at_x, at_y});
                if (begin_[c] != begin_[c + 1]) out.push_back(pixels_[order_[begin_[c]]]);
            }
    }

private:
    static constexpr double beyond = 0.005, margin = 0.05;
    static double quantile(std::vector<double>& values, double share) {
        const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
        std::nth_element(values.begin(), at, values.end());
        return *at;
    }
    static constexpr double most_cells = 1e4;  // along an axis

    // How many pixels each cell has, in the place after its own; returns how many cells have some.
    std::size_t count_cells() {
        for (std::size_t axis = 0; axis < 2; ++axis)
            size_[axis] = static_cast<int>(std::min(most_cells, std::floor((high_[axis] - low_[axis]) / side_))) + 1;
        begin_.assign(index({size_[0] - 1, size_[1] - 1}) + 2, 0);
        std::size_t out = 0;
        for (const Pixel& p : pixels_) out += begin_[cell_of(p) + 1]++ == 0;
        return out;
    }

    std::array<int, 2> place_of(const Pixel& p) const {
        const auto along = [&](float at, std::size_t axis) {
            const double cells = (static_cast<double>(at) - low_[axis]) / side_;
            return static_cast<int>(std::clamp(cells, 0.0, static_cast<double>(size_[axis] - 1)));
        };
        return {along(p.u, 0), along(p.v, 1)};
    }
    std::size_t index(const std::array<int, 2>& place) const {
        return static_cast<std::size_t>(place[1]) * static_cast<std::size_t>(size_[0]) +
               static_cast<std::size_t>(place[0]);
    }
    std::size_t cell_of(const Pixel& p) const { return index(place_of(p)); }

    std::vector<Pixel> pixels_;
    std::vector<float> measured_;  // disparities
    std::array<double, 2> low_, high_;
    double side_;
    std::array<int, 2> size_;
    std::vector<std::uint32_t> begin_, order_;
};

// A disparity that is linear over the picture.
struct Plane {
    double along_u = 0.0, along_v = 0.0, middle = 0.0;
    double off(const Pixel& from, const Pixel& at) const {
        return static_cast<double>(at.disparity) - middle - along_u * static_cast<double>(at.u - from.u) -
               along_v * static_cast<double>(at.v - from.v);
    }
};

struct Fit {
    Plane plane;
    double rms = 0.0, share = 0.0;  // of what is off it, and of the pixels that it is of
};

// By least squares among those that are within `within` of the plane, nearer ones counting more; false where these are
// few, or in line.
bool fit(const Picture& picture, const Pixel& from, int half_width, const std::vector<Pixel>& near, double within,
         Fit& out) {
    const double reach = picture.side() * half_width;
    double sum = 0, u_ = 0, v_ = 0, w_ = 0, uu = 0, uv = 0, vv = 0, uw = 0, vw = 0, ww = 0;
    std::size_t followed = 0;
    for (const Pixel& at : near) {
        if (!(std::abs(out.plane.off(from, at)) <= within)) continue;
        ++followed;
        const double u = static_cast<double>(at.u - from.u) / reach, v = static_cast<double>(at.v - from.v) / reach,
                     w = static_cast<double>(at.disparity - from.disparity);
        const double weight = std::max(0.0, 1.05 - u * u - v * v);
        sum += weight, u_ += weight * u, v_ += weight * v, w_ += weight * w;
        uu += weight * u * u, uv += weight * u * v, vv += weight * v * v;
        uw += weight * u * w, vw += weight * v * w, ww += weight * w * w;
    }
    if (followed < 6) return false;
    uu -= u_ * u_ / sum, uv -= u_ * v_ / sum, vv -= v_ * v_ / sum;
    uw -= u_ * w_ / sum, vw -= v_ * w_ / sum, ww -= w_ * w_ / sum;
    const double determinant = uu * vv - uv * uv;
    if (!(determinant > 1e-6 * sum * sum)) return false;
    const double a = (uw * vv - vw * uv) / determinant, b = (vw * uu - uw * uv) / determinant;
    out.plane = {a / reach, b / reach, static_cast<double>(from.disparity) + (w_ - a * u_ - b * v_) / sum};
    out.rms = std::sqrt(std::max(0.0, ww - a * uw - b * vw) / sum);
    out.share = static_cast<double>(followed) / static_cast<double>(near.size());
    return true;
}

// RMS of what disparities are off planes about them, of the median pixel.
double noise_of(const Picture& picture, std::size_t count) {
    constexpr std::size_t asked = 10000;
    constexpr int half_width = 6;
    constexpr double within = 16.0;
    std::vector<double> found;
    std::vector<Pixel> near;
    for (std::size_t k = 0; k < std::min(count, asked); ++k) {
        const std::size_t i = k * count / std::min(count, asked);
        picture.around(i, half_width, {}, near);
        Fit now;
        now.plane.middle = static_cast<double>(picture[i].disparity);
        // Once more without what is far off it, as pixels are that saw nothing.
        if (fit(picture, picture[i], half_width, near, within, now) &&
            fit(picture, picture[i], half_width, near, std::max(follows, 2.0 * now.rms), now))
            found.push_back(now.rms);
    }
    if (found.empty()) return 0.0;
    const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
    std::nth_element(found.begin(), middle, found.end());
    return *middle;
}

struct Smoothed {
    double disparity;
    bool is_off = false;
};

// The plane that each pixel is of. `scale`: what is off planes, over what it is in a picture as it was measured.
class Smoothing {
public:
    Smoothing(const Picture& picture, double scale) : picture_(picture), scale_(scale) {}

    // Windows grow as long as their planes agree with those of all narrower ones (the intersection of confidence
    // intervals, Goldenshluger and Nemirovski 1997).
    Smoothed operator()(std::size_t i) {
        const Pixel& from = picture_[i];
        Fit found;
        if (of_most(i, majority_half_width, found) && moves(i, found) > follows && moves(i, found) <= level_follows)
            return {found.plane.middle};
        Smoothed out{static_cast<double>(from.disparity)};
        bool any = false;
        int widest = 0;
        double low = -1e300, high = 1e300;
        for (const int half_width : half_widths) {
            picture_.around(i, half_width, {}, near_);
            if (half_width == half_widths[0] && is_alone(from)) return {picture_.measured(i), true};
            const std::size_t pixels = near_.size();
            Fit now;
            bool fits = any ? follow(from, half_width, found.plane, least(), least(), now)
                            : follow_pixel(from, half_width, now);
            if (!any && (!fits || now.rms > bent * scale_)) {
                Fit aside;
                if (follow_aside(i, half_width, aside) && (!fits || aside.rms < now.rms)) now = aside, fits = true;
            }
            fits = fits && now.rms <= flat * scale_ && now.share >= some && moves(i, now) <= follows;
            if (fits) {
                const double by = scale_ * uncertainty(half_width, now, pixels);
                low = std::max(low, now.plane.middle - by), high = std::min(high, now.plane.middle + by);
                fits = low <= high;
            }
            if (!fits && any) break;
            if (!fits) continue;
            any = true;
            found = now;
            widest = half_width;
            out.disparity = now.plane.middle;
        }
        if (is_later() && widest < spot_half_width && of_most(i, spot_half_width, found) &&
            found.rms <= flat * scale_ && moves(i, found) <= spot_follows && is_spot(from, found.plane))
            out.disparity = found.plane.middle;
        return out;
    }

private:
    bool is_later() const { return scale_ < 1.0; }
    double least() const { return follows * scale_; }
    double moves(std::size_t i, const Fit& to) const { return std::abs(to.plane.middle - picture_.measured(i)); }

    // Is hardly any pixel at all about the depth of this one?
    bool is_alone(const Pixel& from) const {
        const Plane level{0.0, 0.0, static_cast<double>(from.disparity)};
        const auto goes = [&](const Pixel& at) { return std::abs(level.off(from, at)) <= level_follows; };
        return near_.size() >= fewest_around &&
               static_cast<std::size_t>(std::count_if(near_.begin(), near_.end(), goes)) < fewest_alike;
    }

    // The plane that most pixels around one are of, whatever it is of itself: of what is narrow, and off by a few
    // steps, no such camera tells the depth.
    bool of_most(std::size_t i, int half_width, Fit& out) {
        picture_.around(i, half_width, {}, near_, true);
        if (near_.size() < fewest_around) return false;
        const auto middle = near_.begin() + static_cast<std::ptrdiff_t>(near_.size() / 2);
        std::nth_element(near_.begin(), middle, near_.end(),
                         [](const Pixel& a, const Pixel& b) { return a.disparity < b.disparity; });
        const Plane level{0.0, 0.0, static_cast<double>(middle->disparity)};
        const double within = half_width == majority_half_width ? follows : least();
        if (!follow(picture_[i], half_width, level, level_follows, within, out)) return false;
        return out.share >= majority && out.rms <= flat;
    }

    // Is the plane all around what is off it?
    bool is_spot(const Pixel& from, const Plane& plane) const {
        std::size_t all = 0, follow = 0;
        for (const Pixel& at : near_) {
            const double away = std::hypot(static_cast<double>(at.u - from.u), static_cast<double>(at.v - from.v));
            if (away < rim * picture_.side() * spot_half_width) continue;
            ++all;
            follow += std::abs(plane.off(from, at)) <= least();
        }
        return static_cast<double>(follow) >= around_spots * static_cast<double>(all);
    }

    // The plane of the window near another one: of what is within `within` of it at first, and of less and less.
    bool follow(const Pixel& from, int half_width, const Plane& near, double within, double least, Fit& out) const {
        out.plane = near;
        for (;; within /= 2.0) {
            if (!fit(picture_, from, half_width, near_, std::max(within, least), out)) return false;
            if (within <= least) return true;
        }
    }

    // The same near the level plane that goes through the pixel.
    bool follow_pixel(const Pixel& from, int half_width, Fit& out) const {
        return follow(from, half_width, {0.0, 0.0, static_cast<double>(from.disparity)}, level_follows, least(), out);
    }

    // Beside creases and borders a window to one side of the pixel knows better (Kuwahara and others 1976).
    bool follow_aside(std::size_t i, int half_width, Fit& best) {
        bool any = false;
        for (int k = 0; k < 9; ++k) {
            if (k == 4) continue;
            picture_.around(i, half_width, {(k % 3 - 1) * (half_width - 1), (k / 3 - 1) * (half_width - 1)}, near_);
            Fit now;
            if (!follow_pixel(picture_[i], half_width, now) || moves(i, now) > 1.0) continue;
            if (any && now.rms >= best.rms) continue;
            best = now;
            any = true;
        }
        return any;
    }

    // By how much a plane's disparity may be off in the middle of a window: noise averages out, and steps do where the
    // plane rises over them.
    double uncertainty(int half_width, const Fit& fit, std::size_t pixels) const {
        const double width = 2.0 * picture_.side() * half_width,
                     rise = width * std::hypot(fit.plane.along_u, fit.plane.along_v),
                     followed = fit.share * static_cast<double>(pixels);
        return 0.5 / std::max(1.0, rise) + deviations * usual_noise / std::sqrt(followed);
    }

    const Picture& picture_;
    double scale_;
    std::vector<Pixel> near_;
};

}  // namespace

SmoothedDepth without_depth_steps(const std::vector<Vec3>& points, double step, const Progress& progress) {
    SmoothedDepth out;
    out.points.resize(points.size());
    out.is_off.resize(points.size());
    if (points.empty()) return out;
    Picture picture(points, step);
    picture.measure_in(std::max(1.0, noise_of(picture, points.size()) / usual_noise));
    std::vector<float> disparities(points.size());
    for (std::size_t pass = 0; pass < passes; ++pass) {
        const Progress part = [&](std::size_t done, std::size_t total) {
            return progress(pass * total + done, passes * total);
        };
        parallel_blocks(
            points.size(), 256,
            [&](std::size_t begin, std::size_t end) {
                Smoothing smoothed(picture, pass == 0 ? 1.0 : later);
                for (std::size_t i = begin; i < end; ++i) {
                    const Smoothed now = smoothed(i);
                    disparities[i] = static_cast<float>(now.disparity);
                    out.is_off[i] = now.is_off;
                }
            },
            progress ? part : Progress{});
        picture.set(disparities);
    }
    for (std::size_t i = 0; i < points.size(); ++i)
        out.points[i] = (picture.measured(i) / static_cast<double>(disparities[i])) * points[i];
    return out;
}

}  // namespace surflux
