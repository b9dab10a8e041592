#include "surflux/area/neighborhood.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace surflux {

namespace {

// Cosine between the normals on either side of the sharpest crease over which surfels share their surroundings;
// excludes the far side of a thin sheet.
constexpr double sharpest_crease = -0.5;
// How far a disk counts, over its radius. With 1 random points on a torus miss .06 % of its area at any density, with
// 1.3 .004 %.
constexpr double domain_ratio = 1.3;
// What lies higher over a disk, over the sum of the two domains, and steeper, is another layer. On a smooth surface
// with n_i . n_j = .8 the slope is .33; a jitter of a tenth of the spacing is that high in one case in a thousand.
constexpr double layer_height = 0.27, layer_slope = 0.35;
// What may stick out over a crease's plane, over the sum of the two radii.
constexpr double crease_tolerance = 0.05;
// How far around a surfel, over its radius, the hull of the points is taken.
constexpr double border_reach = 3.0;
// How far the border lies outside of the outermost samples, over the mean distance of the six nearest
// places: what makes the
// area of the unit square right within 1 % from 1000 samples, by dart throwing or sample elimination or at random.
constexpr double border_margin = 0.1;

std::vector<std::uint32_t> disks_of(const std::vector<bool>& is_disk) {
    std::vector<std::uint32_t> disks;
    for (std::uint32_t i = 0; i < is_disk.size(); ++i)
        if (is_disk[i]) disks.push_back(i);
    return disks;
}

template <class T>
std::vector<T> those(const std::vector<T>& values, const std::vector<std::uint32_t>& which) {
    std::vector<T> out;
    out.reserve(which.size());
    for (std::uint32_t i : which) out.push_back(values[i]);
    return out;
}

Vec3 in_frame(const Frame& frame, const Vec3& v) { return {dot(v, frame.u), dot(v, frame.v), dot(v, frame.n)}; }

// A frame that turns with the cloud, so that the quadrature does too: u points to the nearest neighbour, among equals
// to the first. Neighbours right above or below show no direction.
Frame frame_of(const Surfels& surfels, std::uint32_t i, const std::vector<std::uint32_t>& around) {
    const Vec3& n = surfels.normals[i];
    const auto across = [&](std::uint32_t j) {
        const Vec3 d = surfels.positions[j] - surfels.positions[i];
        return d - dot(d, n) * n;
    };
    double nearest = surfels.radii[i] * 4.0;
    Vec3 u;
    for (std::uint32_t j : around) {
        const Vec3 d = across(j);
        const double distance = length(d);
        if (distance > 1e-6 * surfels.radii[i] && distance < nearest * (1.0 - 1e-6)) {
            nearest = distance;
            u = d;
        }
    }
    if (!(length_squared(u) > 0.0)) return frame_around(n);
    u = normalized(u);
    return {u, cross(n, u), n};
}

// Of the first point from the six nearest others, each place once; 0 where there is none.
double mean_spacing(const std::vector<Point2>& points) {
    constexpr std::size_t wanted = 6;
    constexpr double same_place = 1e-3;  // in units of the disk
    std::vector<std::pair<double, Point2>> nearest;
    for (const Point2& p : points) {
        const double distance = std::hypot(p.x - points[0].x, p.y - points[0].y);
        if (distance < same_place || (nearest.size() == wanted && distance >= nearest.back().first)) continue;
        if (std::any_of(nearest.begin(), nearest.end(),
                        [&](const auto& n) { return std::hypot(n.second.x - p.x, n.second.y - p.y) < same_place; }))
            continue;
        const auto place =
            std::find_if(nearest.begin(), nearest.end(), [&](const auto& n) { return n.first > distance; });
        nearest.insert(place, {distance, p});
        if (nearest.size() > wanted) nearest.pop_back();
    }
    double sum = 0.0;
    for (const auto& n : nearest) sum += n.first;
    return nearest.empty() ? 0.0 : sum / static_cast<double>(nearest.size());
}

}  // namespace

NeighborhoodFinder::NeighborhoodFinder(const Surfels& surfels, const std::vector<bool>& is_disk, double epsilon)
    : surfels_(surfels),
      epsilon_(epsilon),
      disks_(disks_of(is_disk)),
      index_(those(surfels.positions, disks_), those(surfels.radii, disks_)) {}

void NeighborhoodFinder::flat(std::uint32_t i, Neighborhood& out) const { gather(i, 1.0, out); }

void NeighborhoodFinder::curved(std::uint32_t i, Neighborhood& out) const {
    if (!complete(i, domain_ratio, out)) complete(i, 1.0, out);
}

void NeighborhoodFinder::gather(std::uint32_t i, double ratio, Neighborhood& out) const {
    std::vector<Neighbor> near;
    index_.reaching(surfels_.positions[i], surfels_.radii[i], near, ratio);
    std::vector<std::uint32_t> around;
    for (const Neighbor& n : near)
        if (disks_[n.index] != i) around.push_back(disks_[n.index]);
    std::sort(around.begin(), around.end());
    out.frame = frame_of(surfels_, i, around);
    out.radius = ratio * surfels_.radii[i];
    out.surface.assign(1, {i, {}, {0.0, 0.0, 1.0}, 1.0});
    out.crease.clear();
    out.ends.clear();
    for (std::uint32_t j : around) {
        const Member member{j, in_frame(out.frame, (surfels_.positions[j] - surfels_.positions[i]) / out.radius),
                            in_frame(out.frame, surfels_.normals[j]), ratio * surfels_.radii[j] / out.radius};
        (member.normal.z > epsilon_ ? out.surface : out.crease).push_back(member);
    }
}

bool NeighborhoodFinder::complete(std::uint32_t i, double ratio, Neighborhood& out) const {
    gather(i, ratio, out);
    const auto is_layer = [](const Member& m) {
        const double high = layer_height * (1.0 + m.radius);
        return std::abs(m.position.z) > high && std::abs(dot(m.normal, m.position)) > high &&
               std::abs(m.position.z) > layer_slope * std::hypot(m.position.x, m.position.y);
    };
    out.surface.erase(std::remove_if(out.surface.begin() + 1, out.surface.end(), is_layer), out.surface.end());
    std::vector<Member> around(out.surface.begin() + 1, out.surface.end());
    std::vector<OrientedPoint> points;
    for (const Member& m : around) {
        const double reach = 1.0 + m.radius;
        points.push_back({m.position, m.normal, std::exp(-length_squared(m.position) / (reach * reach))});
    }
    around.insert(around.end(), out.crease.begin(), out.crease.end());
    add_creases(around, out);
    out.model = fit_surface(points);
    for (std::size_t k = 1; k < out.surface.size(); ++k) {
        Vec3& p = out.surface[k].position;
        p.z = out.model.height(p.x, p.y);
    }
    out.surface[0].position.z = out.model.z0;
    return add_borders(i, around, out);
}

void NeighborhoodFinder::add_creases(const std::vector<Member>& around, Neighborhood& out) const {
    out.crease.clear();
    for (const Member& m : around) {
        if (m.normal.z > epsilon_ || m.normal.z <= sharpest_crease) continue;
        const double reach = 1.0 + m.radius, tolerance = crease_tolerance * reach, rounding = 1e-6 * reach;
        // Height of j over plane i, and of i over plane j: the same sign, or none where one lies in the other's plane.
        const double over_i = m.position.z, over_j = -dot(m.normal, m.position);
        const double lowest = std::min(over_i, over_j), highest = std::max(over_i, over_j);
        const double side = lowest < -rounding && highest <= rounding   ? 1.0
                            : highest > rounding && lowest >= -rounding ? -1.0
                                                                        : 0.0;
        const auto out_of_line = [&](const Member& k) {
            if (k.normal.z > epsilon_ && side * dot(m.normal, k.position - m.position) > tolerance) return true;
            return dot(k.normal, m.normal) > epsilon_ && side * k.position.z > tolerance;
        };
        if (side == 0.0 || std::any_of(around.begin(), around.end(), out_of_line)) {
            out.crease.push_back(m);
            continue;
        }
        const double slope = std::hypot(m.normal.x, m.normal.y);
        out.ends.push_back(
            {side * m.normal.x / slope, side * m.normal.y / slope, std::max(-side * over_j, 0.0) / slope});
    }
}

bool NeighborhoodFinder::add_borders(std::uint32_t i, const std::vector<Member>& around, Neighborhood& out) const {
    std::vector<Point2> points(1, {0.0, 0.0});
    for (const Member& m : around)
        if (m.normal.z > sharpest_crease) points.push_back({m.position.x, m.position.y});
    const double margin = border_margin * mean_spacing(points);
    if (!(margin > 0.0)) return false;

    // The disks that reach mostly surround the whole disk: no need to look farther then.
    std::vector<HalfPlane> sides;
    const auto ends_disk = [&](const HalfPlane& side) { return side.limit + margin < 1.0; };
    hull_sides(points, sides);
    if (!sides.empty() && std::none_of(sides.begin(), sides.end(), ends_disk)) return true;

    std::vector<Neighbor> near;
    index_.centered_within(surfels_.positions[i], border_reach * out.radius, near);
    points.assign(1, {0.0, 0.0});
    for (const Neighbor& n : near) {
        const std::uint32_t j = disks_[n.index];
        if (dot(surfels_.normals[i], surfels_.normals[j]) <= sharpest_crease) continue;
        const Vec3 d = (surfels_.positions[j] - surfels_.positions[i]) / out.radius;
        points.push_back({dot(d, out.frame.u), dot(d, out.frame.v)});
    }
    hull_sides(points, sides);
    for (const HalfPlane& side : sides)
        if (ends_disk(side)) out.ends.push_back({side.x, side.y, side.limit + margin});
    return !sides.empty();
}

}  // namespace surflux
