#include "surflux/scene/scene.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/error.h"

namespace surflux {

namespace {

template <class T>
void add(std::vector<T>& to, const std::vector<T>& from) {
    to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

void require_areas(const Scene& scene) {
    const std::vector<double>& areas = scene.surfels.areas;
    require(areas.size() == scene.surfels.size(), "scene: its surfels have no areas yet");
    const auto is_wrong = [](double area) { return !(area > 0.0 && std::isfinite(area)); };
    const auto wrong = std::find_if(areas.begin(), areas.end(), is_wrong);
    if (wrong == areas.end()) return;
    const std::uint32_t object = scene.object[static_cast<std::size_t>(wrong - areas.begin())];
    const auto first = std::lower_bound(scene.object.begin(), scene.object.end(), object) - scene.object.begin();
    throw ArgumentError(message("areas: surfel ", wrong - areas.begin() - first,
                                scene.object.back() > 0 ? message(" of object ", object) : std::string(), " has area ",
                                *wrong, ", wanted a positive number"));
}

void append(Scene& scene, const Surfels& surfels) {
    Surfels& all = scene.surfels;
    const auto first = static_cast<std::uint32_t>(all.size());
    require(first == 0 || all.areas.empty() == surfels.areas.empty(),
            "areas: given for some objects of the scene and not for others");
    append_shapes(scene, surfels);
    add(all.areas, surfels.areas);
    for (DiskEnd e : surfels.ends) {
        e.surfel += first;
        all.ends.push_back(e);
    }
    for (std::uint32_t i : surfels.alone) all.alone.push_back(first + i);
}

void append_shapes(Scene& scene, const Surfels& surfels) {
    Surfels& all = scene.surfels;
    const auto first = static_cast<std::uint32_t>(all.size());
    const std::uint32_t object = scene.object.empty() ? 0 : scene.object.back() + 1;
    all.gloss.append(surfels.gloss, first, surfels.size());
    add(all.positions, surfels.positions);
    add(all.normals, surfels.normals);
    add(all.radii, surfels.radii);
    all.reflectance.append(surfels.reflectance);
    all.emission.append(surfels.emission);
    for (Triangle t : surfels.triangles) {
        t.surfel += first;
        all.triangles.push_back(t);
    }
    scene.object.insert(scene.object.end(), surfels.size(), object);
}

bool same_surface(const Scene& scene, std::uint32_t i, std::uint32_t j) {
    if (scene.object[i] == scene.object[j]) return true;
    if (scene.spread.empty()) return false;
    const Surfels& s = scene.surfels;
    const double height = std::abs(dot(s.normals[j], s.positions[i] - s.positions[j]));
    const double low = std::min(scene.spread[i], scene.spread[j]), high = std::max(scene.spread[i], scene.spread[j]);
    return low > 0.0 && height <= high;
}

}  // namespace surflux
