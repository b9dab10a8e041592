#include "surflux/render/smooth_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double same_way = 0.9;   // cosine of normals that one smooth surface may have at neighbouring pixels
constexpr double off_plane = 0.3;  // how far off each other's tangent plane its places may be, over their distance
constexpr double farthest_apart = 20.0;  // pixels, as wide as they are there: more is a gap, or seen edge on

bool is_one_surface(const PixelPlaces& places, std::size_t p, std::size_t q) {
    if (!places.is_seen(p) || !places.is_seen(q)) return false;
    if (places.surfel[p] == places.surfel[q]) return true;
    const Vec3 n = places.normal_at(p), m = places.normal_at(q);
    if (dot(n, m) < same_way) return false;
    const Vec3 way = places.place(q) - places.place(p);
    const double distance = length(way);
    const auto depth = static_cast<double>(std::min(places.depth[p], places.depth[q]));
    return distance <= farthest_apart * places.rays.size_at(depth) &&
           std::max(std::abs(dot(way, n)), std::abs(dot(way, m))) <= off_plane * distance;
}

constexpr std::size_t squares_together = 4;  // a side

// The bits of k backwards: of all rows of a square, those that follow each other are far apart.
std::size_t spread(std::size_t k, std::size_t side) {
    std::size_t reversed = 0, bits = 0;
    while ((std::size_t{1} << bits) < side) ++bits;
    for (std::size_t b = 0; b < bits; ++b) reversed |= ((k >> b) & 1u) << (bits - 1 - b);
    return reversed < side ? reversed : k;
}

}  // namespace

SmoothCells::SmoothCells(const PixelPlaces& places, std::size_t side)
    : width_(places.rays.width), side_(side), joins_(places.size(), 0), cell_(places.size(), none) {
    const std::size_t height = places.rays.height;
    parallel_for(height, 4, [&](std::size_t y) {
        for (std::size_t x = 0; x < width_; ++x) {
            const std::size_t p = y * width_ + x;
            if (x + 1 < width_ && is_one_surface(places, p, p + 1)) joins_[p] |= right;
            if (y + 1 < height && is_one_surface(places, p, p + width_)) joins_[p] |= below;
        }
    });
    // Cells are numbered by squares of squares, so that rays of one probe after another stay close together.
    const std::size_t wide = squares_together * side, bands = (height + wide - 1) / wide;
    std::vector<std::vector<std::uint32_t>> probes(bands);
    parallel_for(bands, 1, [&](std::size_t band) {
        const std::size_t bottom = std::min((band + 1) * wide, height);
        for (std::size_t left = 0; left < width_; left += wide)
            for (std::size_t y = band * wide; y < bottom; y += side)
                for (std::size_t x = left; x < std::min(left + wide, width_); x += side)
                    add_square({x, y, std::min(x + side, width_), std::min(y + side, height)}, places, probes[band]);
    });
    std::vector<std::uint32_t> first(bands + 1, 0);
    for (std::size_t band = 0; band < bands; ++band) {
        first[band + 1] = first[band] + static_cast<std::uint32_t>(probes[band].size());
        probes_.insert(probes_.end(), probes[band].begin(), probes[band].end());
    }
    parallel_for(bands, 1, [&](std::size_t band) {
        const std::size_t begin = band * wide * width_, end = std::min((band + 1) * wide, height) * width_;
        for (std::size_t p = begin; p < end; ++p)
            if (cell_[p] != none) cell_[p] += first[band];
    });
}

// Does another surface begin beside it?
bool SmoothCells::is_at_border(std::size_t pixel, const PixelPlaces& places) const {
    const std::size_t x = pixel % width_, y = pixel / width_;
    const auto ends = [&](bool is_inside, std::size_t from, std::uint8_t joint, std::size_t to) {
        return is_inside && !(joins_[from] & joint) && places.is_seen(to);
    };
    return ends(x + 1 < width_, pixel, right, pixel + 1) || ends(x > 0, pixel - 1, right, pixel - 1) ||
           ends(y + 1 < places.rays.height, pixel, below, pixel + width_) ||
           ends(y > 0, pixel - width_, below, pixel - width_);
}

void SmoothCells::add_square(const Square& in, const PixelPlaces& places, std::vector<std::uint32_t>& probes) {
    const std::size_t row = in.top / side_, column = in.left / side_;
    const auto wanted_x = static_cast<double>(in.left + spread((row + column / side_) % side_, side_));
    const auto wanted_y = static_cast<double>(in.top + spread((column + row / side_) % side_, side_));
    thread_local std::vector<std::size_t> open;
    for (std::size_t y = in.top; y < in.bottom; ++y) {
        for (std::size_t x = in.left; x < in.right; ++x) {
            const std::size_t first = y * width_ + x;
            if (!places.is_seen(first) || cell_[first] != none) continue;
            // All that joins it in the square; the probe is the one nearest to where one is wanted.
            const auto number = static_cast<std::uint32_t>(probes.size());
            double nearest = std::numeric_limits<double>::infinity();
            probes.push_back(0);
            open.assign(1, first);
            cell_[first] = number;
            if (is_at_border(first, places)) {
                probes.back() = static_cast<std::uint32_t>(first);
                continue;
            }
            while (!open.empty()) {
                const std::size_t p = open.back();
                open.pop_back();
                const double off_x = static_cast<double>(p % width_) - wanted_x;
                const double off_y = static_cast<double>(p / width_) - wanted_y;
                if (off_x * off_x + off_y * off_y < nearest) {
                    nearest = off_x * off_x + off_y * off_y;
                    probes.back() = static_cast<std::uint32_t>(p);
                }
                for_neighbors(p, [&](std::size_t q) {
                    if (!in.has(q % width_, q / width_) || cell_[q] != none || is_at_border(q, places)) return;
                    cell_[q] = number;
                    open.push_back(q);
                });
            }
        }
    }
}

}  // namespace surflux
