#include "surflux/area/compile_scene.h"

#include <algorithm>

#include "surflux/area/disk_ends.h"
#include "surflux/area/neighborhood.h"
#include "surflux/core/available_memory.h"
#include "surflux/core/sampling.h"

namespace surflux {

namespace {

constexpr double least_area = 1e-9;  // of a disk: what others cover altogether stays in the scene

void reserve(Surfels& all, const std::vector<const Surfels*>& objects) {
    std::size_t n = 0, triangles = 0;
    for (const Surfels* s : objects) n += s->size(), triangles += s->triangles.size();
    all.positions.reserve(n);
    all.normals.reserve(n);
    all.radii.reserve(n);
    all.areas.reserve(n);
    all.reflectance.reserve(n);
    all.emission.reserve(n);
    all.triangles.reserve(triangles);
}

// Areas and ends of the object whose surfels begin at `first`.
void add_areas_and_ends(Surfels& all, std::uint32_t first, const Surfels& object, const Progress& progress) {
    const std::vector<bool> is_disk = disks_among(object);
    const bool has_disks = std::find(is_disk.begin(), is_disk.end(), true) != is_disk.end();
    DiskEnds found;
    if (object.areas.empty()) {
        std::vector<double> areas;
        found = find_areas_and_ends(object, areas, progress);
        for (std::size_t i = 0; i < areas.size(); ++i)
            all.areas.push_back(std::max(areas[i], least_area * pi * object.radii[i] * object.radii[i]));
    } else {
        if (has_disks) found = find_disk_ends(object, AreaOptions{}.epsilon, progress);
        all.areas.insert(all.areas.end(), object.areas.begin(), object.areas.end());
    }
    for (DiskEnd& end : found.ends) {
        end.surfel += first;
        all.ends.push_back(end);
    }
    for (const std::uint32_t i : found.alone) all.alone.push_back(first + i);
}

}  // namespace

Scene compile_scene(const std::vector<const Surfels*>& objects, std::vector<Light> lights, Coincidence& coincidence,
                    const Progress& progress) {
    give_back_memory();  // of reading or sampling the objects
    Scene scene;
    reserve(scene.surfels, objects);
    for (const Surfels* object : objects) {
        append_shapes(scene, *object);
        report(progress, 0, 1);
    }
    scene.lights = std::move(lights);
    coincidence = find_coincidence(scene, progress);
    std::uint32_t first = 0;
    for (const Surfels* object : objects) {
        add_areas_and_ends(scene.surfels, first, *object, progress);
        first += static_cast<std::uint32_t>(object->size());
    }
    count_once(scene, coincidence, progress);
    return scene;
}

}  // namespace surflux
