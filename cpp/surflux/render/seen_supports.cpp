#include "surflux/render/seen_supports.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

// Bounds of x / z over a circle around (x, z), in pixels of `count`: all of them for one that reaches the plane of the
// eye.
std::pair<int, int> bounds(double x, double z, double radius, double near, double tan_half, int count) {
    if (z - radius <= near) return {0, count};
    const double tangent = std::sqrt(std::max(0.0, x * x + z * z - radius * radius));
    const double scale = 1.0 / ((z - radius) * (z + radius) * tan_half);
    const auto pixel = [&](double slope) { return 0.5 * count * (std::clamp(slope * scale, -1.0, 1.0) + 1.0); };
    return {static_cast<int>(std::floor(pixel(x * z - radius * tangent))),
            static_cast<int>(std::ceil(pixel(x * z + radius * tangent)))};
}

}  // namespace

SeenTiles::Rectangle box_of(const Vec3& center, double radius, const DrawnView& view) {
    const auto near = static_cast<double>(view.near_depth);
    const auto [left, right] = bounds(center.x, center.z, radius, near, static_cast<double>(view.tan_x), view.width);
    const auto [top, bottom] = bounds(center.y, center.z, radius, near, static_cast<double>(view.tan_y), view.height);
    return {left, std::max(top, view.top) - view.top, right, std::min(bottom, view.top + view.rows) - view.top};
}

std::vector<DrawnSupport> seen_supports(const MeshlessField& field, const std::vector<std::uint32_t>& functions,
                                        const CameraFrame& frame, const Vec3& origin, const DrawnView& view,
                                        const SeenTiles& tiles) {
    const MultilevelBasis& basis = field.basis;
    const auto far = static_cast<double>(view.far_depth);
    std::vector<DrawnSupport> out(functions.size());
    std::vector<char> seen(functions.size(), 0);
    parallel_for(functions.size(), 1024, [&](std::size_t k) {
        const std::uint32_t j = functions[k];
        const Vec3 center = frame.to_camera(basis.position(j));
        const double radius = basis.radius(j), reach = 1.0001 * radius;
        if (center.z + reach <= 0.0) return;
        const SeenTiles::Rectangle box = box_of(center, reach, view);
        DrawnSupport& f = out[k];
        store(f.center, center - origin);
        store(f.normal, frame.turn(basis.normal(j)));
        f.object = static_cast<float>(basis.object(j));
        const SeenTiles::Rectangle part = tiles.part(box, f.center, static_cast<float>(reach), f.normal, f.object);
        if (part.empty()) return;
        seen[k] = 1;
        const auto square = static_cast<float>(radius * radius);
        f.shrink = std::min(1.0f / square, std::numeric_limits<float>::max());
        store(f.all, field.coefficients[j]);
        store(f.direct, field.direct[j]);
        if (field.gathered[j]) {
            store(f.value, field.values[j].all);
            store(f.direct_value, field.values[j].direct);
            f.gathered = 1.0f;
        }
        f.nearest = static_cast<float>(std::clamp((center.z - reach) / far - 1e-6, 0.0, 1.0));
        const auto width = static_cast<float>(view.width), height = static_cast<float>(view.rows);
        for (float (&cut)[4] : f.cuts) cut[0] = cut[1] = cut[2] = 0.0f, cut[3] = -1.0f;
        std::size_t cuts = 0;
        for (const SupportCut& cut : basis.cuts(j)) {
            // By how far the function's point is within it, which is small where coordinates are not.
            const Vec3 normal = frame.turn(cut.normal);
            const double within = dot(cut.normal, basis.position(j)) - cut.offset;
            store(f.cuts[cuts], normal);
            f.cuts[cuts++][3] = static_cast<float>(dot(normal, center - origin) - within);
            if (cuts == 2) break;
        }
        f.corners[0] = 2.0f * static_cast<float>(part.left) / width - 1.0f;
        f.corners[1] = 2.0f * static_cast<float>(part.top) / height - 1.0f;
        f.corners[2] = 2.0f * static_cast<float>(part.right) / width - 1.0f;
        f.corners[3] = 2.0f * static_cast<float>(part.bottom) / height - 1.0f;
    });
    std::size_t count = 0;
    for (std::size_t k = 0; k < out.size(); ++k)
        if (seen[k]) out[count++] = out[k];
    out.resize(count);
    return out;
}

}  // namespace surflux
