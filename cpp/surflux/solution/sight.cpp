#include "surflux/solution/sight.h"

#include <algorithm>
#include <limits>

#include "surflux/core/parallel.h"

namespace surflux {

namespace {

constexpr double heights[] = {0.25, 0.05};  // of the distance
constexpr double under_cover = 0.5;         // of the headroom
constexpr double alike = 4.0;               // the higher of two covers over the lower
constexpr double same_way = 0.5;            // cosine of normals of disks that make one surface
constexpr int most_own_disks = 4;           // over a place, of a noisy cloud

// Is one place under a cover so low that hardly any light gets there from where the other one is, and the other is not?
bool parted_by_cover(double headroom_p, double headroom_q, double distance) {
    const double lower = std::min(headroom_p, headroom_q), higher = std::max(headroom_p, headroom_q);
    return Sight::is_low(lower, distance) && higher > alike * lower;
}

Hit first_hit(const Tracer& tracer, const Vec3& from, const Vec3& normal, const Vec3& direction, double length) {
    thread_local std::vector<Ray> ray(1);
    thread_local std::vector<Hit> hit;
    ray[0] = {{from, normal, Hit::none}, direction, length};
    tracer.closest(ray, hit);
    return hit[0];
}

}  // namespace

Sight::Sight(const Tracer& tracer, const Scene& scene)
    : tracer_(tracer), scene_(scene), triangles_(triangle_ranges(scene.surfels)) {}

// Disks of a cloud stand off the surface that they stand for; patches are where they are.
bool Sight::is_own_surface(const Hit& hit, const Vec3& normal) const {
    return triangles_[hit.surfel] == triangles_[hit.surfel + 1] &&
           dot(scene_.surfels.normals[hit.surfel], normal) > same_way;
}

double Sight::headroom(const Vec3& p, const Vec3& normal) const {
    // From beyond what coincides with the surface.
    const double beyond = 4.0 * tracer_.contact(p);
    double from = beyond;
    for (int disk = 0; disk <= most_own_disks; ++disk) {
        const Hit hit = first_hit(tracer_, p + from * normal, normal, normal, std::numeric_limits<double>::infinity());
        if (!hit) break;
        from += hit.distance;
        if (!is_own_surface(hit, normal) || from > 2.0 * scene_.surfels.radii[hit.surfel]) return from;
        from += beyond;
    }
    return std::numeric_limits<double>::infinity();
}

std::vector<Sight::Place> Sight::places(const Progress& progress) const {
    const Surfels& s = scene_.surfels;
    std::vector<Place> out(s.size());
    parallel_blocks(
        s.size(), 1024,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                out[i] = {s.positions[i], s.normals[i], headroom(s.positions[i], s.normals[i])};
        },
        progress);
    return out;
}

bool Sight::free(const Vec3& from, const Vec3& to, const Vec3& normal_p, const Vec3& normal_q) const {
    const Vec3 way = to - from;
    const double far = length(way);
    if (!(far > 0.0)) return true;
    const Hit hit = first_hit(tracer_, from, normal_p, way / far, far);
    return !hit || is_own_surface(hit, normal_p) || is_own_surface(hit, normal_q);
}

bool Sight::joined(const Place& p, const Place& q) const {
    const double distance = length(q.position - p.position);
    // No ray is so short; of two that face apart there they are the sides of a sheet.
    if (!(distance > 4.0 * tracer_.contact(p.position))) return dot(p.normal, q.normal) > 0.0;
    if (parted_by_cover(p.headroom, q.headroom, distance)) return false;
    for (const double height : heights) {
        const auto above = [&](const Place& place) {
            return place.position + std::min(height * distance, under_cover * place.headroom) * place.normal;
        };
        if (free(above(p), above(q), p.normal, q.normal)) return true;
    }
    return false;
}

bool Sight::overlooks(const Vec3& p, const Vec3& normal, const Place& q) const {
    const double distance = length(q.position - p);
    if (!(distance > 4.0 * tracer_.contact(p))) return dot(normal, q.normal) > 0.0;
    const Vec3 from = p + 4.0 * tracer_.contact(p) * normal,
               way = q.position + std::min(heights[0] * distance, under_cover * q.headroom) * q.normal - from;
    const double far = length(way);
    return dot(way, normal) > 0.0 && !first_hit(tracer_, from, normal, way / far, far);
}

bool Sight::sees(const Vec3& p, const Vec3& normal, double& headroom_p, const Place& q) const {
    const double distance = length(q.position - p);
    if (is_low(q.headroom, distance)) {
        if (headroom_p < 0.0) headroom_p = headroom(p, normal);
        if (parted_by_cover(headroom_p, q.headroom, distance)) return false;
    }
    if (overlooks(p, normal, q)) return true;
    if (headroom_p < 0.0) headroom_p = headroom(p, normal);
    return joined({p, normal, headroom_p}, q);
}

Sight::Sites::Sites(const std::vector<Vec3>& positions, const std::vector<Vec3>& normals)
    : positions_(positions), normals_(normals), headroom_(new std::atomic<double>[positions.size()]) {
    for (std::size_t k = 0; k < positions.size(); ++k) headroom_[k] = -1.0;
}

Sight::Place Sight::Sites::place(const Sight& sight, std::uint32_t site) const {
    const Vec3 &p = positions_[site], &normal = normals_[site];
    double headroom = headroom_[site].load(std::memory_order_relaxed);
    if (headroom < 0.0) {  // whoever finds it finds the same
        headroom = sight.headroom(p, normal);
        headroom_[site].store(headroom, std::memory_order_relaxed);
    }
    return {p, normal, headroom};
}

bool Sight::keep_joined(const Vec3& point, const Vec3& normal, const Sites& sites, const std::vector<Rgb>& values,
                        std::vector<Interpolation::Weight>& weights, std::uint32_t own) const {
    double above = -1.0;  // the headroom, once it is asked for
    const auto is_joined = [&](std::uint32_t site) { return sees(point, normal, above, sites.place(*this, site)); };
    if (own == none) {
        std::sort(weights.begin(), weights.end(), [](const Interpolation::Weight& a, const Interpolation::Weight& b) {
            return a.weight > b.weight || (a.weight == b.weight && a.site < b.site);
        });
        const auto first =
            std::find_if(weights.begin(), weights.end(), [&](const auto& w) { return is_joined(w.site); });
        if (first == weights.end()) return false;
        own = first->site;
    }
    const auto parted = [&](const Interpolation::Weight& w) {
        return w.site != own && (!(w.weight > 0.0) || (differ_much(values[w.site], values[own]) && !is_joined(w.site)));
    };
    const auto end = std::remove_if(weights.begin(), weights.end(), parted);
    double sum = 0.0;
    for (auto w = weights.begin(); w != end; ++w) sum += w->weight;
    if (!(sum > 0.0)) {
        weights.assign(1, {own, 1.0});
        return true;
    }
    weights.erase(end, weights.end());
    for (Interpolation::Weight& w : weights) w.weight /= sum;
    return true;
}

}  // namespace surflux
