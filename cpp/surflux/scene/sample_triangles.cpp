#include "surflux/scene/sample_triangles.h"

#include <algorithm>
#include <utility>

#include "surflux/core/error.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"

namespace surflux {

TriangleSamples::TriangleSamples(std::vector<std::array<Vec3, 3>> triangles, std::size_t count, std::uint64_t seed)
    : triangles_(std::move(triangles)), count_(count), seed_(seed) {
    double total = 0.0;
    up_to_.reserve(triangles_.size());
    for (const auto& [a, b, c] : triangles_) up_to_.push_back(total += 0.5 * length(cross(b - a, c - a)));
    require(total > 0.0, "mesh: its faces have no area to sample");
}

SurfacePoint TriangleSamples::operator[](std::size_t i) const {
    Random random(seed_, i);
    const double at = (static_cast<double>(i) + random.uniform()) / static_cast<double>(count_) * area();
    const auto found = std::upper_bound(up_to_.begin(), up_to_.end(), at);
    const std::size_t t = std::min<std::size_t>(static_cast<std::size_t>(found - up_to_.begin()), up_to_.size() - 1);
    const double s = random.uniform();
    const Vec3 w = square_to_triangle(s, random.uniform());
    const auto& [a, b, c] = triangles_[t];
    return {w.x * a + w.y * b + w.z * c, static_cast<std::uint32_t>(t)};
}

}  // namespace surflux
