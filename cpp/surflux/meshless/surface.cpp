#include "surflux/meshless/surface.h"

#include <algorithm>

namespace surflux {

Surface::Surface(const Scene& scene) {
    for (const Triangle& t : scene.surfels.triangles)
        if (area_of(t) > 0.0) triangles.push_back(t);
    const std::vector<std::uint32_t> first = triangle_ranges(scene.surfels);
    for (std::uint32_t i = 0; i < scene.surfels.size(); ++i) {
        const Vec3& center = scene.surfels.positions[i];
        const Triangle disk{center, center, center, i};
        if (first[i] == first[i + 1] && surface_area(scene, disk) > 0.0) triangles.push_back(disk);
    }
    const auto object = [&](const Triangle& t) { return scene.object[t.surfel]; };
    std::stable_sort(triangles.begin(), triangles.end(),
                     [&](const Triangle& s, const Triangle& t) { return object(s) < object(t); });
    for (const std::uint32_t o : scene.object) area.resize(std::max<std::size_t>(area.size(), o + std::size_t{1}));
    for (const Triangle& t : triangles) area[object(t)] += surface_area(scene, t);
}

double surface_area(const Scene& scene, const Triangle& t) {
    if (!(t.a == t.b && t.b == t.c)) return area_of(t);
    const Surfels& s = scene.surfels;
    const double square = 2.0 * s.radii[t.surfel] * s.radii[t.surfel];
    return s.areas.empty() ? square : std::min(square, s.areas[t.surfel]);
}

}  // namespace surflux
