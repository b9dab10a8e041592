#include "surflux/lights/sample_points.h"

#include "surflux/core/sampling.h"

namespace surflux {

SurfelPoints::SurfelPoints(const Surfels& surfels)
    : surfels_(surfels), begin_(triangle_ranges(surfels)), up_to_(surfels.triangles.size()) {
    for (std::size_t i = 0; i < surfels.size(); ++i) {
        double total = 0.0;
        for (std::uint32_t t = begin_[i]; t < begin_[i + 1]; ++t) up_to_[t] = total += area_of(surfels.triangles[t]);
        for (std::uint32_t t = begin_[i]; t < begin_[i + 1]; ++t) up_to_[t] /= total;
    }
}

Vec3 SurfelPoints::at(std::uint32_t i, double s, double t) const {
    if (!is_patch(i)) return surfels_.positions[i];
    std::uint32_t k = begin_[i];
    double below = 0.0;
    while (k + 1 < begin_[i + 1] && s >= up_to_[k]) below = up_to_[k++];
    const Triangle& triangle = surfels_.triangles[k];
    const Vec3 w = square_to_triangle((s - below) / (up_to_[k] - below), t);
    return w.x * triangle.a + w.y * triangle.b + w.z * triangle.c;
}

}  // namespace surflux
