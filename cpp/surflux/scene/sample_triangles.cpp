#include "surflux/scene/sample_triangles.h"

#include <algorithm>

#include "surflux/core/error.h"
#include "surflux/core/random.h"
#include "surflux/core/sampling.h"

namespace surflux {

std::vector<SurfacePoint> sample_triangles(const std::vector<std::array<Vec3, 3>>& triangles, std::size_t count,
                                           std::uint64_t seed) {
    std::vector<double> up_to(triangles.size());
    double total = 0.0;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const auto& [a, b, c] = triangles[t];
        up_to[t] = total += 0.5 * length(cross(b - a, c - a));
    }
    require(total > 0.0, "mesh: its faces have no area to sample");
    std::vector<SurfacePoint> out(count);
    for (std::size_t i = 0; i < count; ++i) {
        Random random(seed, i);
        const double at = (static_cast<double>(i) + random.uniform()) / static_cast<double>(count) * total;
        const auto found = std::upper_bound(up_to.begin(), up_to.end(), at);
        const std::size_t t = std::min<std::size_t>(static_cast<std::size_t>(found - up_to.begin()), up_to.size() - 1);
        const double s = random.uniform();
        const Vec3 w = square_to_triangle(s, random.uniform());
        const auto& [a, b, c] = triangles[t];
        out[i] = {w.x * a + w.y * b + w.z * c, static_cast<std::uint32_t>(t)};
    }
    return out;
}

}  // namespace surflux
