#include "surflux/area/compile_scene.h"

#include <algorithm>
#include <cmath>

#include "surflux/area/disk_ends.h"
#include "surflux/area/neighborhood.h"
#include "surflux/core/available_memory.h"
#include "surflux/core/sampling.h"

namespace surflux {

namespace {

constexpr double least_area = 1e-9;  // of a disk: what others cover altogether stays in the scene

// Given areas are held against those of so many disks that emit: a twentieth of a second, good to a thousandth.
constexpr std::size_t disks_held = 10'000;
constexpr double unlike = 0.05;  // of their logarithms: of coarse convex clouds, D04's own areas are as much too large

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

// Marks of disks that emit, or of so many of them; empty where none does.
std::vector<char> some_emitters(const Surfels& object, const std::vector<bool>& is_disk) {
    std::vector<std::uint32_t> emitters;
    for (std::uint32_t i = 0; i < object.size(); ++i)
        if (is_disk[i] && luminance(object.emission[i]) > 0.0) emitters.push_back(i);
    if (emitters.empty()) return {};
    std::vector<char> out(object.size(), 0);
    const std::size_t every = 1 + emitters.size() / disks_held;
    for (std::size_t k = 0; k < emitters.size(); k += every) out[emitters[k]] = 1;
    return out;
}

// Of the marked disks, the power by the areas given over that by their own, where these are above 0.
double ratio_of_powers(const Surfels& object, const std::vector<char>& marked, const std::vector<double>& own) {
    double given_sum = 0.0, own_sum = 0.0;
    for (std::size_t i = 0; i < object.size(); ++i) {
        if (!marked[i] || !(own[i] > 0.0)) continue;
        given_sum += luminance(object.emission[i]) * object.areas[i];
        own_sum += luminance(object.emission[i]) * own[i];
    }
    return own_sum > 0.0 ? given_sum / own_sum : 1.0;
}

// Areas and ends of the object whose surfels begin at `first`, and what is odd about them.
void add_areas_and_ends(Surfels& all, std::uint32_t first, std::uint32_t number, const Surfels& object,
                        Coincidence& odd, const Progress& progress) {
    const std::vector<bool> is_disk = disks_among(object);
    DiskEnds found;
    if (object.areas.empty()) {
        std::vector<double> areas;
        found = find_areas_and_ends(object, areas, {}, progress);
        for (std::size_t i = 0; i < areas.size(); ++i)
            all.areas.push_back(std::max(areas[i], least_area * pi * object.radii[i] * object.radii[i]));
    } else {
        const std::vector<char> emitters = some_emitters(object, is_disk);
        if (!emitters.empty()) {
            std::vector<double> own;
            found = find_areas_and_ends(object, own, emitters, progress);
            const double ratio = ratio_of_powers(object, emitters, own);
            if (std::abs(std::log(ratio)) > unlike) odd.unlike_areas.push_back({number, ratio});
        } else if (std::count(is_disk.begin(), is_disk.end(), true) > 0) {
            found = find_disk_ends(object, AreaOptions{}.epsilon, progress);
        }
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
    for (std::uint32_t k = 0; k < objects.size(); ++k) {
        add_areas_and_ends(scene.surfels, first, k, *objects[k], coincidence, progress);
        first += static_cast<std::uint32_t>(objects[k]->size());
    }
    std::vector<char> has_own_areas;
    for (const Surfels* object : objects) has_own_areas.push_back(object->areas.empty());
    // Areas that are shares among several objects are less than the object's own disks would have alone.
    for (const std::uint32_t kept : count_once(scene, coincidence, progress, has_own_areas)) {
        std::vector<UnlikeAreas>& unlike = coincidence.unlike_areas;
        unlike.erase(std::remove_if(unlike.begin(), unlike.end(), [&](const auto& u) { return u.object == kept; }),
                     unlike.end());
    }
    return scene;
}

}  // namespace surflux
