#include "surflux/render/parted_surfels.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/meshless/level_light.h"

namespace surflux {

namespace {

constexpr int most_rows = 4;  // of places over a triangle, where it is as wide as supports are

// The middles of the rows^2 congruent parts of a triangle.
void places_on(const Triangle& t, int rows, std::vector<Vec3>& out) {
    const Vec3 u = (t.b - t.a) / rows, v = (t.c - t.a) / rows;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; i + j < rows; ++j) {
            const Vec3 corner = t.a + static_cast<double>(i) * u + static_cast<double>(j) * v;
            out.push_back(corner + (u + v) / 3.0);
            if (i + j + 1 < rows) out.push_back(corner + 2.0 / 3.0 * (u + v));
        }
}

}  // namespace

PartedSurfels::PartedSurfels(const MeshlessField& field, const Scene& scene, const BasisSight& sight)
    : field_(field),
      scene_(scene),
      sight_(sight),
      triangles_(triangle_ranges(scene.surfels)),
      is_known_(scene.surfels.size(), 0),
      parted_(scene.surfels.size()) {}

void PartedSurfels::find(std::vector<std::uint32_t> surfels) {
    const auto is_known = [&](std::uint32_t i) { return is_known_[i] != 0; };
    surfels.erase(std::remove_if(surfels.begin(), surfels.end(), is_known), surfels.end());
    std::sort(surfels.begin(), surfels.end());
    surfels.erase(std::unique(surfels.begin(), surfels.end()), surfels.end());
    parallel_for(surfels.size(), 64, [&](std::size_t k) {
        const std::uint32_t i = surfels[k];
        if (is_patch(i)) parted_[i] = parted_from(i);  // disks of clouds hide each other
        is_known_[i] = 1;
    });
}

PartedSurfels::Parted PartedSurfels::parted_from(std::uint32_t i) const {
    const MultilevelBasis& basis = field_.basis;
    const Surfels& s = scene_.surfels;
    const Vec3& normal = s.normals[i];
    const std::uint32_t object = scene_.object[i];
    thread_local std::vector<BasisWeight> weights;
    std::vector<std::uint32_t> reached, seen, speaking;
    Parted out;
    std::vector<Vec3> places;
    const auto add = [&](std::vector<std::uint32_t>& to) {
        for (const BasisWeight& w : weights) to.push_back(w.function);
    };
    for (std::size_t level = 0; level < basis.levels(); ++level) {
        basis.weights(level, s.positions[i], normal, object, weights);
        double radius = s.radii[i];
        for (const BasisWeight& w : weights) radius = std::min(radius, basis.radius(level, w.function));
        const int rows =
            radius > 0.0 ? static_cast<int>(std::ceil(std::min<double>(most_rows, 2.0 * s.radii[i] / radius))) : 1;
        places.clear();
        for (std::uint32_t t = triangles_[i]; t < triangles_[i + 1]; ++t) places_on(s.triangles[t], rows, places);
        reached.clear(), seen.clear();
        for (const Vec3& place : places) {
            basis.weights(level, place, normal, object, weights);
            if (weights.empty()) continue;
            add(reached);
            sight_.at_level(level, place, normal, object, Hit::none, weights);
            add(seen);
        }
        std::sort(reached.begin(), reached.end());
        std::sort(seen.begin(), seen.end());
        speaking.clear();
        std::size_t functions = 0;
        for (auto from = reached.begin(); from != reached.end(); ++functions) {
            const auto to = std::upper_bound(from, reached.end(), *from);
            const auto by = std::equal_range(seen.begin(), seen.end(), *from);
            if (by.first != by.second) speaking.push_back(*from);
            out.is_mixed |= by.first != by.second && by.second - by.first != to - from;
            from = to;
        }
        if (speaking.size() == functions && !out.is_mixed) continue;
        out.levels |= std::uint64_t{1} << level;
        out.seen.insert(out.seen.end(), speaking.begin(), speaking.end());
    }
    return out;
}

bool PartedSurfels::at(std::uint32_t i, const Vec3& point, const Vec3& normal, MeshlessField::At& out) const {
    const MultilevelBasis& basis = field_.basis;
    const std::uint32_t object = scene_.object[i];
    const Parted& parted = parted_[i];
    if (parted.is_mixed) return field_.at(point, normal, object, sight_, out);
    thread_local std::vector<BasisWeight> weights;
    out = {};
    const auto is_unseen = [&](const BasisWeight& w) {
        return !std::binary_search(parted.seen.begin(), parted.seen.end(), w.function);
    };
    for (std::size_t level = 0; level < basis.levels(); ++level) {
        basis.weights(level, point, normal, object, weights);
        if (parted.levels >> level & 1)
            weights.erase(std::remove_if(weights.begin(), weights.end(), is_unseen), weights.end());
        if (weights.empty() && basis.is_coarsest(level, object)) return false;
        basis.to_shares(level, object, weights);
        LevelLight(field_, weights).add_to(out);
    }
    out.clamp();
    return true;
}

}  // namespace surflux
