#include "surflux/render/light_pixels.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr float least_cosine = 0.9f;    // of normals on one smooth piece
constexpr float largest_slope = 0.5f;   // of the way between two of its places, out of the surface
constexpr float farthest = 8.0f;        // of them, in widths of a pixel at their depth
constexpr float largest_change = 0.1f;  // of light from pixel to pixel, where it is even
constexpr float largest_share = 0.5f;   // of the radius of a support that a pixel reaches over

float dot_of(const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

float distance(const float* a, const float* b) {
    const float d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return std::sqrt(dot_of(d, d));
}

// far: how far apart they may be.
bool is_one_piece(const float* place, const float* normal, const float* other, const float* other_normal, float far) {
    if (place[3] != other[3] || dot_of(normal, other_normal) < least_cosine) return false;
    const float d[3] = {other[0] - place[0], other[1] - place[1], other[2] - place[2]};
    const float away = dot_of(d, normal), squared = dot_of(d, d);
    return squared <= far * far && away * away <= largest_slope * largest_slope * squared;
}

bool is_even(const float* light, const float* other) {
    float off = 0.0f, most = 0.0f;
    for (int c = 0; c < 3; ++c) {
        off = std::max(off, std::abs(light[c] - other[c]));
        most = std::max({most, light[c], other[c]});
    }
    return off <= largest_change * most;
}

}  // namespace

LightPixels::LightPixels(const std::vector<float>& places, const std::vector<float>& normals,
                         const std::vector<float>& depths, int width, int height, int samples, float pixel)
    : width_(static_cast<std::size_t>(width / samples)),
      height_(static_cast<std::size_t>(height / samples)),
      samples_(static_cast<std::size_t>(samples)),
      places_(4 * width_ * height_, 0.0f),
      normals_(places_.size(), 0.0f),
      depths_(width_ * height_, 0.0f),
      extents_(width_ * height_, 0.0f),
      pixel_(pixel),
      seen_(places.size() / 4, 0),
      alone_(places.size() / 4, 0) {
    parallel_for(depths_.size(), 1024, [&](std::size_t p) {
        thread_local std::vector<std::size_t> of_one;
        of_one.clear();
        for (std::size_t k = 0; k < samples_ * samples_; ++k) {
            const std::size_t at = subpixel(p, k);
            if (places[4 * at + 3] < 0.0f) continue;
            seen_[at] = 1;
            of_one.push_back(at);
        }
        float *place = &places_[4 * p], *normal = &normals_[4 * p];
        place[3] = -1.0f;
        if (of_one.empty()) return;
        const std::size_t first = of_one[of_one.size() / 2];
        const float *middle = &places[4 * first], *facing = &normals[4 * first];
        const float far = farthest * pixel * depths[4 * first];
        double sum[3] = {0, 0, 0}, turned[3] = {0, 0, 0};
        std::size_t together = 0;
        for (const std::size_t at : of_one) {
            if (at != first && !is_one_piece(middle, facing, &places[4 * at], &normals[4 * at], far)) {
                alone_[at] = 1;
                continue;
            }
            ++together;
            depths_[p] = std::max(depths_[p], depths[4 * at]);
            extents_[p] = std::max(extents_[p], 2.0f * distance(&places[4 * at], middle));
            for (std::size_t axis = 0; axis < 3; ++axis) {
                sum[axis] += static_cast<double>(places[4 * at + axis]);
                turned[axis] += static_cast<double>(normals[4 * at + axis]);
            }
        }
        const double length = std::sqrt(turned[0] * turned[0] + turned[1] * turned[1] + turned[2] * turned[2]);
        for (int axis = 0; axis < 3; ++axis) {
            place[axis] = together == 1 ? middle[axis] : static_cast<float>(sum[axis] / static_cast<double>(together));
            normal[axis] = together == 1 ? facing[axis] : static_cast<float>(turned[axis] / length);
        }
        place[3] = middle[3];
    });
    for (const float extent : extents_) largest_extent_ = std::max(largest_extent_, extent);
}

LightPixels LightPixels::alone(const std::vector<float>& places, const std::vector<float>& normals,
                               const std::vector<float>& depths) const {
    const int samples = static_cast<int>(samples_);
    LightPixels out(places, normals, depths, samples * width(), samples * height(), 1,
                    pixel_ / static_cast<float>(samples));
    for (std::size_t p = 0; p < alone_.size(); ++p)
        if (alone_[p] == 0) out.places_[4 * p + 3] = -1.0f, out.depths_[p] = 0.0f;
    return out;
}

void LightPixels::divide_where_uneven(const std::vector<float>& light) {
    if (samples_ == 1) return;
    parallel_for(depths_.size(), 1024, [&](std::size_t p) {
        if (places_[4 * p + 3] < 0.0f) return;
        const std::size_t x = p % width_, y = p / width_;
        const float far = farthest * pixel_ * depths_[p];
        const auto differs = [&](std::size_t other) {
            return is_one_piece(&places_[4 * p], &normals_[4 * p], &places_[4 * other], &normals_[4 * other], far) &&
                   !is_even(&light[4 * p], &light[4 * other]);
        };
        if ((x > 0 && differs(p - 1)) || (x + 1 < width_ && differs(p + 1)) || (y > 0 && differs(p - width_)) ||
            (y + 1 < height_ && differs(p + width_)))
            divide(p);
    });
}

void LightPixels::divide_where_fine(const std::vector<DrawnSupport>& supports, const Vec3& origin,
                                    const DrawnView& view) {
    if (samples_ == 1) return;
    constexpr std::size_t grain = 1024;
    std::vector<std::vector<std::size_t>> found((supports.size() + grain - 1) / grain);
    parallel_blocks(supports.size(), grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const DrawnSupport& support = supports[k];
            const float radius = 1.0f / std::sqrt(support.shrink);
            if (support.gathered == 0.0f || radius > largest_extent_ / largest_share) continue;
            const SeenTiles::Rectangle box = box_of(stored(support.center) + origin, static_cast<double>(radius), view);
            for (int y = std::max(0, box.top); y < std::min(height(), box.bottom); ++y) {
                for (int x = std::max(0, box.left); x < std::min(width(), box.right); ++x) {
                    const std::size_t p = static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(x);
                    const float* place = &places_[4 * p];
                    if (place[3] == support.object && radius * largest_share < extents_[p] &&
                        distance(place, support.center) < radius + extents_[p])
                        found[begin / grain].push_back(p);
                }
            }
        }
    });
    for (const std::vector<std::size_t>& pixels : found)
        for (const std::size_t p : pixels) divide(p);
}

double LightPixels::share_alone() const {
    std::size_t seen = 0, alone = 0;
    for (std::size_t p = 0; p < seen_.size(); ++p) {
        seen += seen_[p] != 0;
        alone += seen_[p] != 0 && alone_[p] != 0;
    }
    return seen > 0 ? static_cast<double>(alone) / static_cast<double>(seen) : 0.0;
}

}  // namespace surflux
