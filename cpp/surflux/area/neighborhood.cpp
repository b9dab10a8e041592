#include "surflux/area/neighborhood.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surflux/core/morton.h"
#include "surflux/core/thread_scratch.h"
#include "surflux/neighbors/disk_kernel.h"
#include "surflux/neighbors/piles.h"

namespace surflux {

namespace {

// Cosine between the normals on either side of the sharpest crease over which surfels share their surroundings;
// excludes the far side of a thin sheet.
constexpr double sharpest_crease = -0.5;
// What lies higher over a disk than layer_height, over the sum of the two domains, and steeper, is another layer. On a
// smooth surface with n_i . n_j = .8 the slope is .33.
constexpr double layer_slope = 0.35;
// Between the normals of disks at one place that are one disk: they are apart by what floats or an estimate leave.
constexpr double pile_cosine = 0.999;
// What may stick out over a crease's plane, over the sum of the two radii.
constexpr double crease_tolerance = 0.05;
// How far around a surfel, over its spacing, the hull of the points is taken; where points crowd, over .6 of its
// domain, which is as wide as a cell.
constexpr double border_reach = 5.0;
// How far the border lies outside of the outermost samples, over the mean distance of the six nearest places. So the
// area of the unit square is right within .5 % from 1000 samples of blue noise (by dart throwing or elimination).
constexpr double border_margin = 0.05;
// How far off, over the same spacing, other objects' samples still go on with the surface.
constexpr double beside_reach = 2.0;
// A corner that no sample fills up to this far, over the same spacing, is still a corner.
constexpr double corner_tolerance = 0.6;

double across(double x, double y) { return std::sqrt(x * x + y * y); }

// Whether one of those with n_i . n_j > epsilon is of another layer.
bool is_layer(const Member& m) {
    const double high = layer_height * (1.0 + m.radius);
    return std::abs(m.position.z) > high && std::abs(dot(m.normal, m.position)) > high &&
           std::abs(m.position.z) > layer_slope * across(m.position.x, m.position.y);
}

// A frame that turns with the cloud, so that the quadrature does too: u points to the nearest neighbour, among equals
// to the first. Neighbours right above or below show no direction.
Frame frame_towards(const Vec3& normal, double radius, const std::vector<Vec3>& offsets) {
    double nearest = 4.0 * radius;
    Vec3 u;
    for (const Vec3& offset : offsets) {
        const Vec3 d = offset - dot(offset, normal) * normal;
        const double distance = length(d);
        if (distance > 1e-6 * radius && distance < nearest * (1.0 - 1e-6)) {
            nearest = distance;
            u = d;
        }
    }
    if (!(length_squared(u) > 0.0)) return frame_around(normal);
    u = normalized(u);
    return {u, cross(normal, u), normal};
}

// Mean distance of the six nearest from the middle, each place once; 0 where there is none.
double mean_spacing(const std::vector<Member>& around) {
    constexpr std::size_t wanted = 6;
    constexpr double same_place = 1e-3;  // in units of the domain
    std::vector<std::pair<double, Vec3>> nearest;
    for (const Member& m : around) {
        const double distance = length(m.position);
        if (distance < same_place || (nearest.size() == wanted && distance >= nearest.back().first)) continue;
        if (std::any_of(nearest.begin(), nearest.end(),
                        [&](const auto& n) { return length(n.second - m.position) < same_place; }))
            continue;
        const auto place =
            std::find_if(nearest.begin(), nearest.end(), [&](const auto& n) { return n.first > distance; });
        nearest.insert(place, {distance, m.position});
        if (nearest.size() > wanted) nearest.pop_back();
    }
    double sum = 0.0;
    for (const auto& n : nearest) sum += n.first;
    return nearest.empty() ? 0.0 : sum / static_cast<double>(nearest.size());
}

}  // namespace

Vec3 in_frame(const Frame& frame, const Vec3& v) { return {dot(v, frame.u), dot(v, frame.v), dot(v, frame.n)}; }

std::vector<NeighborhoodFinder::Disk> NeighborhoodFinder::disks_of(const Surfels& surfels,
                                                                   const std::vector<bool>& is_disk,
                                                                   const Progress& progress) {
    std::vector<std::uint32_t> given;
    std::vector<Vec3> positions, normals;
    std::vector<double> radii;
    for (std::uint32_t i = 0; i < surfels.size(); ++i) {
        if (!is_disk[i]) continue;
        given.push_back(i);
        positions.push_back(surfels.positions[i]);
        normals.push_back(surfels.normals[i]);
        radii.push_back(surfels.radii[i]);
    }
    const std::vector<std::vector<std::uint32_t>> piles = find_piles(positions, normals, radii, pile_cosine, progress);
    constexpr std::uint32_t none = 0xffffffffu, below = none - 1;  // not in a pile; in one, but not its first
    std::vector<std::uint32_t> pile_of(piles.empty() ? 0 : given.size(), none);
    for (std::uint32_t p = 0; p < piles.size(); ++p)
        for (const std::uint32_t member : piles[p]) pile_of[member] = member == piles[p].front() ? p : below;
    std::vector<Disk> disks;
    begin_.push_back(0);
    for (const std::uint32_t k : morton_order(positions, progress)) {
        const std::uint32_t pile = piles.empty() ? none : pile_of[k];
        if (pile == below) continue;
        disks.push_back({positions[k], normals[k], radii[k], given[k]});
        if (pile == none)
            surfels_.push_back(given[k]);
        else
            for (const std::uint32_t member : piles[pile]) surfels_.push_back(given[member]);
        begin_.push_back(static_cast<std::uint32_t>(surfels_.size()));
    }
    return disks;
}

template <class T>
std::vector<T> NeighborhoodFinder::of_each(const std::vector<Disk>& disks, T Disk::* member) {
    std::vector<T> out;
    out.reserve(disks.size());
    for (const Disk& disk : disks) out.push_back(disk.*member);
    return out;
}

NeighborhoodFinder::NeighborhoodFinder(const Surfels& surfels, const std::vector<bool>& is_disk, double epsilon,
                                       const Progress& progress)
    : epsilon_(epsilon),
      disks_(disks_of(surfels, is_disk, progress)),
      index_(of_each(disks_, &Disk::position), of_each(disks_, &Disk::radius), progress) {}

void NeighborhoodFinder::flat(std::size_t i, Neighborhood& out) const { gather(i, 1.0, out); }

void NeighborhoodFinder::curved(std::size_t i, Neighborhood& out, const Beside& beside) const {
    if (!complete(i, domain_ratio, out, beside)) complete(i, 1.0, out, beside);
}

void NeighborhoodFinder::gather(std::size_t i, double ratio, Neighborhood& out) const {
    const Disk& disk = disks_[i];
    thread_local std::vector<Neighbor> near;
    thread_local std::vector<Vec3> offsets;
    const ThreadScratch near_scratch(near);
    const ThreadScratch offsets_scratch(offsets);
    index_.reaching(disk.position, disk.radius, near, ratio);
    // A disk whose radius squared is 0 reaches nothing, not even itself.
    near.erase(std::remove_if(near.begin(), near.end(), [i](const Neighbor& n) { return n.index == i; }), near.end());
    std::sort(near.begin(), near.end(),
              [this](const Neighbor& a, const Neighbor& b) { return disks_[a.index].surfel < disks_[b.index].surfel; });
    for (const Neighbor& n : near) offsets.push_back(disks_[n.index].position - disk.position);
    out.frame = frame_towards(disk.normal, disk.radius, offsets);
    out.radius = ratio * disk.radius;
    out.surface.assign(1, {disk.surfel, {}, {0.0, 0.0, 1.0}, 1.0});
    out.crease.clear();
    out.ends.clear();
    out.others.clear();
    out.others_ends.clear();
    for (std::size_t k = 0; k < near.size(); ++k) {
        const Disk& other = disks_[near[k].index];
        const Member member{other.surfel, in_frame(out.frame, offsets[k] / out.radius),
                            in_frame(out.frame, other.normal), other.radius / disk.radius};
        (member.normal.z > epsilon_ ? out.surface : out.crease).push_back(member);
    }
}

bool NeighborhoodFinder::complete(std::size_t i, double ratio, Neighborhood& out, const Beside& beside) const {
    gather(i, ratio, out);
    out.surface.erase(std::remove_if(out.surface.begin() + 1, out.surface.end(), is_layer), out.surface.end());
    std::vector<Member> around(out.surface.begin() + 1, out.surface.end());
    std::vector<OrientedPoint> points;
    for (const Member& m : around) {
        const double reach = 1.0 + m.radius;
        points.push_back({m.position, m.normal, std::exp(-length_squared(m.position) / (reach * reach))});
    }
    around.insert(around.end(), out.crease.begin(), out.crease.end());
    add_creases(around, out);
    out.crease_ends = out.ends.size();
    out.model = fit_surface(points);
    for (std::size_t k = 1; k < out.surface.size(); ++k) {
        Vec3& p = out.surface[k].position;
        p.z = out.model.height(p.x, p.y);
    }
    out.surface[0].position.z = out.model.z0;
    return add_borders(i, around, out, beside);
}

void NeighborhoodFinder::add_creases(const std::vector<Member>& around, Neighborhood& out) const {
    out.crease.clear();
    for (const Member& m : around) {
        if (m.normal.z > epsilon_ || m.normal.z <= sharpest_crease) continue;
        const double reach = 1.0 + m.radius, tolerance = crease_tolerance * reach, rounding = 1e-6 * reach;
        // Height of j over plane i, and of i over plane j: the same sign, or none where one lies in the other's plane.
        const double over_i = m.position.z, over_j = -dot(m.normal, m.position);
        const double lowest = std::min(over_i, over_j), highest = std::max(over_i, over_j);
        double side = lowest < -rounding && highest <= rounding   ? 1.0
                      : highest > rounding && lowest >= -rounding ? -1.0
                                                                  : 0.0;
        // Both on the edge itself, as a mesh's corners are, stored once for each face: the rest of the surface tells.
        if (side == 0.0 && std::max(-lowest, highest) <= tolerance) {
            double sum = 0.0;
            for (const Member& k : around)
                if (k.normal.z > epsilon_) sum += dot(m.normal, k.position - m.position);
            side = sum < 0.0 ? 1.0 : sum > 0.0 ? -1.0 : 0.0;
        }
        const auto out_of_line = [&](const Member& k) {
            if (k.normal.z > epsilon_ && side * dot(m.normal, k.position - m.position) > tolerance) return true;
            return dot(k.normal, m.normal) > epsilon_ && side * k.position.z > tolerance;
        };
        if (side == 0.0 || std::any_of(around.begin(), around.end(), out_of_line)) {
            out.crease.push_back(m);
            continue;
        }
        const double slope = across(m.normal.x, m.normal.y);
        out.ends.push_back(
            {side * m.normal.x / slope, side * m.normal.y / slope, std::max(-side * over_j, 0.0) / slope});
    }
}

bool NeighborhoodFinder::add_borders(std::size_t i, const std::vector<Member>& around, Neighborhood& out,
                                     const Beside& beside) const {
    std::vector<Point2> points(1, {0.0, 0.0}), others;
    for (const Member& m : around)
        if (m.normal.z > sharpest_crease) points.push_back({m.position.x, m.position.y});
    const double spacing = mean_spacing(around);
    if (!(spacing > 0.0)) return false;
    const Disk& disk = disks_[i];
    const auto place_of = [&](const Vec3& position) {
        return in_frame(out.frame, (position - disk.position) / out.radius);
    };
    double spacing_of_all = spacing;
    if (beside) {
        std::vector<Vec3> positions;
        beside(beside_reach * spacing * out.radius, positions);
        std::vector<Member> all = around;
        for (const Vec3& position : positions) {
            all.push_back({disk.surfel, place_of(position), {0.0, 0.0, 1.0}, 1.0});
            others.push_back({all.back().position.x, all.back().position.y});
        }
        spacing_of_all = mean_spacing(all);
        points.insert(points.end(), others.begin(), others.end());
    }
    const double margin = border_margin * spacing_of_all;

    // The disks that reach mostly surround the whole disk: no need to look farther then.
    std::vector<HalfPlane> sides;
    const auto ends_disk = [&](const HalfPlane& side) { return side.limit + margin < 1.0; };
    hull_sides(points, sides);
    if (!sides.empty() && std::none_of(sides.begin(), sides.end(), ends_disk)) return true;

    thread_local std::vector<Neighbor> near;
    const ThreadScratch scratch(near);
    index_.centered_within(disk.position, border_reach * std::max(spacing_of_all, 0.6) * out.radius, near);
    points = others;
    points.push_back({0.0, 0.0});
    for (const Neighbor& n : near) {
        const Disk& other = disks_[n.index];
        const double cosine = dot(disk.normal, other.normal);
        if (cosine <= sharpest_crease) continue;
        const Vec3 place = place_of(other.position);
        if (cosine > epsilon_ &&
            is_layer({other.surfel, place, in_frame(out.frame, other.normal), other.radius / disk.radius}))
            continue;
        points.push_back({place.x, place.y});
    }
    hull_sides(points, sides);
    sharpen_corners(sides, corner_tolerance * spacing_of_all);
    for (const HalfPlane& side : sides)
        if (ends_disk(side)) out.ends.push_back({side.x, side.y, side.limit + margin});
    return !sides.empty();
}

}  // namespace surflux
