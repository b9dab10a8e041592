#include "surflux/scene/whole_scene.h"

#include <cmath>
#include <limits>

#include "surflux/core/error.h"

namespace surflux {

namespace {

constexpr double largest = 1e30;  // of coordinates and lengths, as arguments have it
constexpr double off_unit = 1e-3;

// NaN is in no range.
bool is_in(double value, double low, double below) { return value >= low && value < below; }
bool is_in(const Vec3& value, double low, double below) {
    return is_in(value.x, low, below) && is_in(value.y, low, below) && is_in(value.z, low, below);
}
bool is_place(const Vec3& p) { return is_in(p, -largest, largest); }
bool is_unit(const Vec3& n) { return std::abs(length(n) - 1.0) < off_unit; }

template <class Values>
void require_in(const char* name, const Values& values, double low, double below) {
    for (const auto& value : values) require(is_in(value, low, below), name, ": out of range");
}

void require_surfels(const Surfels& s) {
    const std::size_t n = s.size();
    require(s.normals.size() == n && s.radii.size() == n && s.areas.size() == n && s.reflectance.size() == n &&
                s.emission.size() == n,
            "positions: wanted one for each surfel, as of all else");
    for (const Vec3& p : s.positions) require(is_place(p), "positions: out of range");
    for (const Vec3& normal : s.normals) require(is_unit(normal), "normals: wanted unit vectors");
    require_in("radii", s.radii, std::numeric_limits<double>::min(), largest);
    require_in("areas", s.areas, 0.0, largest * largest);
    require_in("reflectance", s.reflectance.palette(), 0.0, 1.0);
    require_in("emission", s.emission.palette(), 0.0, std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < n && !s.gloss.empty(); ++i)
        require(is_in(s.gloss.specular(i), 0.0, 1.0) && is_in(s.gloss.exponent(i), 0.0, largest),
                "specular: out of range");
}

void require_shapes(const Surfels& s) {
    const std::size_t n = s.size();
    std::uint32_t before = 0;
    for (const Triangle& t : s.triangles) {
        require(t.surfel < n && t.surfel >= before, "triangle_surfel: wanted ascending surfels");
        require(is_place(t.a) && is_place(t.b) && is_place(t.c), "corners: out of range");
        before = t.surfel;
    }
    before = 0;
    for (const DiskEnd& end : s.ends) {
        require(end.surfel < n && end.surfel >= before, "end_surfel: wanted ascending surfels");
        require(is_unit(end.normal) && is_in(end.limit, -largest, largest), "end_limit: out of range");
        before = end.surfel;
    }
    for (std::size_t k = 0; k < s.alone.size(); ++k)
        require(s.alone[k] < n && (k == 0 || s.alone[k] > s.alone[k - 1]), "alone: wanted ascending surfels");
}

}  // namespace

void require_whole(const Scene& scene) {
    require_surfels(scene.surfels);
    require_shapes(scene.surfels);
    const std::size_t n = scene.surfels.size();
    require(scene.object.size() == n && n > 0, "object: wanted that of each surfel");
    for (std::size_t i = 0; i < n; ++i) {
        const std::uint32_t before = i == 0 ? 0 : scene.object[i - 1];
        require(scene.object[i] == before || (i > 0 && scene.object[i] == before + 1), "object: wanted 0, 1, 2 ...");
    }
    for (const Cover& c : scene.covers) require(c.below < n && c.above < n, "covers: wanted surfels below ", n);
    for (const Sheet& s : scene.sheets) require(s.one < n && s.other < n, "sheets: wanted surfels below ", n);
    require(scene.spread.empty() || scene.spread.size() == n, "spread: wanted that of each surfel");
    require_in("spread", scene.spread, 0.0, largest);
}

}  // namespace surflux
