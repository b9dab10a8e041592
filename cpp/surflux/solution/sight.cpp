#include "surflux/solution/sight.h"

#include <algorithm>

namespace surflux {

namespace {

constexpr double heights[] = {0.25, 0.05};  // of the distance

}  // namespace

bool Sight::joined(const Vec3& p, const Vec3& normal_p, const Vec3& q, const Vec3& normal_q) const {
    const double distance = length(q - p);
    if (!(distance > 0.0)) return true;
    thread_local std::vector<Ray> ray(1);
    thread_local std::vector<char> free;
    for (const double height : heights) {
        const Vec3 from = p + (height * distance) * normal_p, way = q + (height * distance) * normal_q - from;
        const double far = length(way);
        if (!(far > 0.0)) return true;
        ray[0] = {{from, normal_p, Hit::none}, way / far, far};
        tracer_.free(ray, free);
        if (free[0]) return true;
    }
    return false;
}

void Sight::keep_joined(const Vec3& point, const Vec3& normal, const std::vector<Vec3>& positions,
                        const std::vector<Vec3>& normals, const std::vector<double>& values,
                        std::vector<Interpolation::Weight>& weights) const {
    if (weights.size() < 2) return;
    const auto [least, most] = std::minmax_element(weights.begin(), weights.end(),
                                                   [&](const Interpolation::Weight& a, const Interpolation::Weight& b) {
                                                       return values[a.site] < values[b.site];
                                                   });
    if (!differ_much(values[least->site], values[most->site])) return;
    double sum = 0.0;
    std::size_t kept = 0;
    const Interpolation::Weight heaviest = *std::max_element(
        weights.begin(), weights.end(), [](const auto& a, const auto& b) { return a.weight < b.weight; });
    for (const Interpolation::Weight& w : weights)
        if (w.weight > 0.0 && joined(point, normal, positions[w.site], normals[w.site])) {
            sum += w.weight;
            weights[kept++] = w;
        }
    if (kept == 0) return weights.assign(1, {heaviest.site, 1.0});
    weights.resize(kept);
    for (Interpolation::Weight& w : weights) w.weight /= sum;
}

}  // namespace surflux
