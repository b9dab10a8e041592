#include "surflux/radiosity/pair_exchange.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "surflux/core/gauss_legendre.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/polygon.h"
#include "surflux/trace/coincident.h"
#include "surflux/trace/tracer.h"

namespace surflux {

namespace {

// The circle in a square of the disk's area: what is farther out may lie behind a wall that the disk adjoins.
constexpr double within_cell = 0.886;
// Contact distances within which rays take a surface for the one that they leave; doubles round off so much less.
constexpr double taken_for_own = 2.0, float_over_double = taken_for_own * 0x1p-29;
// Of the outer contour integral, for patches that may touch and for others: each brings factors of a cube's patches to
// 2e-8.
constexpr int touching_points = 12, apart_points = 6;

}  // namespace

PairExchange::PairExchange(const Scene& scene, double epsilon, bool by_rays, const PairsTuning& tuning)
    : scene_(scene),
      epsilon_(epsilon),
      mid_ratio_(tuning.mid_ratio),
      far_ratio_(tuning.far_ratio),
      patches_far_ratio_(tuning.patches_far_ratio),
      points_(scene.surfels),
      distances_(scene.surfels),
      touch_(by_rays ? taken_for_own : float_over_double),
      backs_(find_coincident(scene).twin),
      counted_(scene.surfels.size(), 1.0),
      extent_(scene.surfels.size()) {
    const Surfels& s = scene.surfels;
    std::size_t emitters = 0;
    for (std::uint32_t i = 0; i < s.size(); ++i) emitters += emits(i);
    few_emit_ = emitters <= s.size() / 8;
    node_begin_.push_back(0);
    for (std::uint32_t i = 0; i < s.size(); ++i) {
        const Triangle *begin = points_.triangles_begin(i), *end = points_.triangles_end(i);
        if (begin == end) {
            extent_[i] = std::sqrt(s.areas[i] / pi);
            // Degree 3 on the disk of area S (four points at 1/sqrt 2 of its radius).
            const Frame frame = frame_around(s.normals[i]);
            for (const Vec3& axis : {frame.u, -frame.u, frame.v, -frame.v})
                nodes_.push_back(s.positions[i] + (extent_[i] * std::sqrt(0.5)) * axis);
        } else {
            counted_[i] = s.areas[i] / points_.area(i);
            extent_[i] = 0.0;
            for (const Triangle* t = begin; t != end; ++t)
                for (const Vec3& p : {t->a, t->b, t->c}) extent_[i] = std::max(extent_[i], length(p - s.positions[i]));
            if (const SurfelPoints::Parallelogram* p = points_.parallelogram(i)) {  // 2 x 2 Gauss-Legendre
                const double g = 0.5 - std::sqrt(1.0 / 12.0);
                for (double a : {g, 1.0 - g})
                    for (double b : {g, 1.0 - g}) nodes_.push_back(p->corner + a * p->u + b * p->v);
            } else {  // degree 2 on each triangle
                const double area = points_.area(i);
                for (const Triangle* t = begin; t != end; ++t) {
                    const Vec3 sum = t->a + t->b + t->c;
                    for (const Vec3& corner : {t->a, t->b, t->c}) {
                        nodes_.push_back(sum / 6.0 + 0.5 * corner);
                        node_weight_.push_back(area_of(*t) / (3.0 * area));
                    }
                }
            }
        }
        node_begin_.push_back(static_cast<std::uint32_t>(nodes_.size()));
        node_weight_.resize(nodes_.size(), 0.25);
    }
    polygons_.resize(s.size());
    for (std::uint32_t i = 0; i < s.size(); ++i) {
        if (const SurfelPoints::Parallelogram* p = points_.parallelogram(i)) {
            Polygon polygon{p->corner, p->corner + p->u, p->corner + p->u + p->v, p->corner + p->v};
            if (dot(cross(p->u, p->v), s.normals[i]) < 0.0) std::reverse(polygon.begin(), polygon.end());
            polygons_[i].push_back(std::move(polygon));
        } else {
            for (const Triangle* t = points_.triangles_begin(i); t != points_.triangles_end(i); ++t)
                polygons_[i].push_back({t->a, t->b, t->c});
        }
    }
}

double PairExchange::kernel(const Vec3& x_i, const Vec3& n_i, const Vec3& x_j, const Vec3& n_j) const {
    const Vec3 d = x_j - x_i;
    const double to_j = dot(n_i, d), to_i = -dot(n_j, d);
    if (to_j <= 0.0 || to_i <= 0.0) return 0.0;
    const double squared = length_squared(d);
    return to_j * to_i / (pi * squared * squared);
}

bool PairExchange::same_surface(std::uint32_t i, std::uint32_t j, double squared) const {
    const Surfels& s = scene_.surfels;
    // Disks that just close the surface touch only the nearest of the ring around: 1.5 takes in all of it.
    const double reach = 1.5 * (s.radii[i] + s.radii[j]);
    return squared < reach * reach && !points_.is_patch(i) && !points_.is_patch(j) &&
           dot(s.normals[i], s.normals[j]) > epsilon_ && surflux::same_surface(scene_, i, j);
}

// Disks of a sheet with two sides stand off it, so that parts of one side seem to face the other side of neighbours.
bool PairExchange::is_back_of_neighbor(std::uint32_t i, std::uint32_t j, double squared) const {
    return backs_[j] != Hit::none && (backs_[j] == i || same_surface(i, backs_[j], squared));
}

PairExchange::Octagon PairExchange::octagon_of_disk(std::uint32_t i) const {
    const Frame frame = frame_around(scene_.surfels.normals[i]);
    // The regular octagon of area S: 2 sqrt(2) rho^2.
    const double rho = std::sqrt(scene_.surfels.areas[i] / (2.0 * std::sqrt(2.0)));
    Octagon out;
    for (std::size_t k = 0; k < out.size(); ++k) {
        const double angle = pi / 4.0 * static_cast<double>(k);
        out[k] = scene_.surfels.positions[i] + rho * (std::cos(angle) * frame.u + std::sin(angle) * frame.v);
    }
    return out;
}

double PairExchange::to_polygons(std::uint32_t i, const Vec3& point, std::uint32_t j) const {
    const Vec3& normal = scene_.surfels.normals[i];
    if (dot(scene_.surfels.normals[j], point - scene_.surfels.positions[j]) <= contact(i, j)) return 0.0;
    if (!points_.is_patch(j)) {
        const Octagon octagon = octagon_of_disk(j);
        return element_to_polygon(point, normal, octagon.data(), octagon.size());
    }
    double sum = 0.0;
    for (const Triangle* t = points_.triangles_begin(j); t != points_.triangles_end(j); ++t) {
        const Vec3 corners[3] = {t->a, t->b, t->c};
        sum += element_to_polygon(point, normal, corners, 3);
    }
    return counted_[j] * sum;
}

double PairExchange::kernel(std::uint32_t i, const Vec3& at_i, std::uint32_t j, const Vec3& at_j) const {
    return kernel(at_i, scene_.surfels.normals[i], at_j, scene_.surfels.normals[j]);
}

// F_ij: the closed form at points spread over i, by Gauss-Legendre on parallelograms.
double PairExchange::near_factor(std::uint32_t i, std::uint32_t j) const {
    static constexpr double gauss_at[4] = {0.0694318442029737, 0.3300094782075719, 0.6699905217924281,
                                           0.9305681557970263};
    static constexpr double gauss_weight[4] = {0.1739274225687269, 0.3260725774312731, 0.3260725774312731,
                                               0.1739274225687269};
    if (!points_.is_patch(i)) return near_factor_of_disk(i, j);
    if (!points_.parallelogram(i)) return near_factor_of_triangles(i, j);
    double sum = 0.0;
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b)
            sum += gauss_weight[a] * gauss_weight[b] * to_polygons(i, points_.at(i, gauss_at[a], gauss_at[b]), j);
    return sum;
}

// The same at three points of each triangle, or of parts of few triangles: exact to second order in each.
double PairExchange::near_factor_of_triangles(std::uint32_t i, std::uint32_t j) const {
    constexpr double fewest = 16.0;
    const Triangle *first = points_.triangles_begin(i), *last = points_.triangles_end(i);
    const int cuts =
        std::max(1, static_cast<int>(std::ceil(std::sqrt(fewest / (3.0 * static_cast<double>(last - first))))));
    double sum = 0.0, area = 0.0;
    for (const Triangle* t = first; t != last; ++t) {
        const Vec3 u = (t->b - t->a) / cuts, v = (t->c - t->a) / cuts;
        double mean = 0.0;
        const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
            const Vec3 middle = (a + b + c) / 6.0;
            for (const Vec3* corner : {&a, &b, &c}) mean += to_polygons(i, middle + 0.5 * *corner, j);
        };
        for (int a = 0; a < cuts; ++a)
            for (int b = 0; a + b < cuts; ++b) {
                const Vec3 low = t->a + a * u + b * v;
                add(low, low + u, low + v);
                if (a + b + 1 < cuts) add(low + u, low + u + v, low + v);
            }
        sum += area_of(*t) * mean / (3.0 * cuts * cuts);
        area += area_of(*t);
    }
    return sum / area;
}

// The same on two rings, whose squared radii are Gauss-Legendre's: between two coaxial disks of one radius to 2 % from
// a distance of .05 of that on, to .2 % from .2 on, but for the octagon.
double PairExchange::near_factor_of_disk(std::uint32_t i, std::uint32_t j) const {
    static constexpr double ring_at[2] = {0.4597008433809831, 0.8880738339771153};
    constexpr int turns = 8;
    const Vec3& center = scene_.surfels.positions[i];
    const Frame frame = frame_around(scene_.surfels.normals[i]);
    double sum = 0.0;
    for (int ring = 0; ring < 2; ++ring)
        for (int k = 0; k < turns; ++k) {
            const double angle = (k + 0.5 * ring) * 2.0 * pi / turns, radius = ring_at[ring] * extent_[i];
            const Vec3 at = center + radius * (std::cos(angle) * frame.u + std::sin(angle) * frame.v);
            sum += to_polygons(i, at, j) / (2 * turns);
        }
    return sum;
}

// G_ij by the kernel between all nodes of either.
double PairExchange::between_nodes(std::uint32_t i, std::uint32_t j) const {
    const Surfels& s = scene_.surfels;
    double sum = 0.0;
    for (std::uint32_t a = node_begin_[i]; a < node_begin_[i + 1]; ++a)
        for (std::uint32_t b = node_begin_[j]; b < node_begin_[j + 1]; ++b)
            sum += node_weight_[a] * node_weight_[b] * kernel(nodes_[a], s.normals[i], nodes_[b], s.normals[j]);
    return s.areas[i] * s.areas[j] * sum;
}

// G_ij of two patches: what of each lies in front of the other. The numerical one of the integrals runs along the edges
// of the smaller patch: along longer ones its points would step over it.
double PairExchange::between_polygons(std::uint32_t i, std::uint32_t j, int count, Grading grading) const {
    if (extent_[i] > extent_[j]) std::swap(i, j);
    const Surfels& s = scene_.surfels;
    thread_local std::vector<Polygon> front;
    front.resize(polygons_[j].size());
    for (std::size_t b = 0; b < front.size(); ++b)
        clip_to_front(polygons_[j][b], s.positions[i], s.normals[i], front[b]);
    thread_local Polygon before;
    double g = 0.0;
    for (const Polygon& a : polygons_[i]) {
        clip_to_front(a, s.positions[j], s.normals[j], before);
        if (before.size() < 3) continue;
        for (const Polygon& b : front)
            if (b.size() >= 3) g += polygon_exchange(before, b, count, grading);
    }
    return counted_[i] * counted_[j] * g;
}

PairExchange::Pair PairExchange::operator()(std::uint32_t i, std::uint32_t j) const {
    const Surfels& s = scene_.surfels;
    const Vec3 d = s.positions[j] - s.positions[i];
    const double squared = length_squared(d);
    const double to_j = dot(s.normals[i], d), to_i = -dot(s.normals[j], d);
    const double extent = std::max(extent_[i], extent_[j]);
    const double areas = s.areas[i] * s.areas[j];
    const bool patches = points_.is_patch(i) && points_.is_patch(j);
    if (squared > far_ratio_ * far_ratio_ * extent * extent) {
        if (patches && squared <= patches_far_ratio_ * patches_far_ratio_ * extent * extent) {
            const double g = between_nodes(i, j);
            return g > 0.0 ? Pair{g, Range::far} : Pair{};
        }
        if (to_j <= 0.0 || to_i <= 0.0) return {};
        return {areas * to_j * to_i / (pi * squared * squared), Range::far};
    }
    if (same_surface(i, j, squared)) {
        if (to_j <= 0.0 || to_i <= 0.0) return {};
        // On a smooth surface the kernel tends to curvature^2 / 4 pi as r -> 0, but noise makes it grow without bound:
        // closer than the spacing, r stays there.
        const double bounded = std::max(squared, 0.25 * (s.areas[i] + s.areas[j]));
        return {areas * to_j * to_i / (pi * squared * bounded), Range::same_surface};
    }
    if ((to_j <= 0.0 || to_i <= 0.0) && is_back_of_neighbor(i, j, squared)) return {};
    const bool is_mid = squared > mid_ratio_ * mid_ratio_ * extent * extent;
    if (is_mid && !patches) {
        const double g = between_nodes(i, j);
        return g > 0.0 ? Pair{g, Range::mid} : Pair{};
    }
    if (!rise_above_each_other(i, j)) return {};
    if (patches) {
        const double g = between_polygons(i, j, is_mid ? apart_points : touching_points);
        const double least = std::min(s.areas[i], s.areas[j]);
        return g > 1e-12 * least ? Pair{std::min(g, least), is_mid ? Range::mid : Range::near} : Pair{};
    }
    // The outer integral belongs over the smaller surfel: what that covers has an edge on the larger one, between
    // points.
    constexpr double larger = 1.25;
    const double over_i = extent_[i] > larger * extent_[j] ? 0.0 : extent_[j] > larger * extent_[i] ? 1.0 : 0.5;
    double g = 0.0;
    if (over_i > 0.0) g += over_i * s.areas[i] * near_factor(i, j);
    if (over_i < 1.0) g += (1.0 - over_i) * s.areas[j] * near_factor(j, i);
    return g > 0.0 ? Pair{std::min(g, std::min(s.areas[i], s.areas[j])), Range::near} : Pair{};
}

// False for coplanar neighbours above all, and for either side of a sheet: nothing to integrate.
bool PairExchange::rise_above_each_other(std::uint32_t i, std::uint32_t j) const {
    const Surfels& s = scene_.surfels;
    const Vec3 d = s.positions[j] - s.positions[i];
    const double sine = 1.1 * length(cross(s.normals[i], s.normals[j]));  // 1.1: the octagon's corners
    const double least = contact(i, j);
    return dot(s.normals[i], d) + extent_[j] * sine > least && -dot(s.normals[j], d) + extent_[i] * sine > least;
}

// Two parallelograms of which none has a corner behind the other.
bool PairExchange::face_wholly(std::uint32_t i, std::uint32_t j) const {
    const Surfels& s = scene_.surfels;
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
        for (const Vec3& corner : polygons_[a].front())
            if (dot(s.normals[b], corner - s.positions[b]) < 0.0) return false;
        return true;
    };
    return points_.parallelogram(i) && points_.parallelogram(j) && before(i, j) && before(j, i);
}

// G_ij of such, by the rule of Gauss and Legendre with `count` points along each edge.
template <int count>
double PairExchange::by_quadrature(std::uint32_t i, std::uint32_t j) const {
    static const auto rule = [] {
        std::pair<std::vector<double>, std::vector<double>> out;
        gauss_legendre(count, out.first, out.second);
        return out;
    }();
    constexpr std::size_t points = count * count;
    const Surfels& s = scene_.surfels;
    // From the centre of i, so that positions far from the origin lose nothing.
    const auto spread = [&](std::uint32_t k, double (&x)[points], double (&y)[points], double (&z)[points],
                            double (&weight)[points]) {
        const SurfelPoints::Parallelogram& p = *points_.parallelogram(k);
        for (std::size_t a = 0, at = 0; a < count; ++a)
            for (std::size_t b = 0; b < count; ++b, ++at) {
                const Vec3 q = p.corner - s.positions[i] + rule.first[a] * p.u + rule.first[b] * p.v;
                x[at] = q.x, y[at] = q.y, z[at] = q.z;
                weight[at] = rule.second[a] * rule.second[b];
            }
    };
    double xi[points], yi[points], zi[points], wi[points], xj[points], yj[points], zj[points], wj[points];
    spread(i, xi, yi, zi, wi);
    spread(j, xj, yj, zj, wj);
    const Vec3 &ni = s.normals[i], &nj = s.normals[j];
    double sum = 0.0;
    for (std::size_t a = 0; a < points; ++a) {
        double terms[points];
        for (std::size_t b = 0; b < points; ++b) {
            const double dx = xj[b] - xi[a], dy = yj[b] - yi[a], dz = zj[b] - zi[a];
            const double squared = dx * dx + dy * dy + dz * dz;
            terms[b] = wj[b] * (ni.x * dx + ni.y * dy + ni.z * dz) * -(nj.x * dx + nj.y * dy + nj.z * dz) /
                       (squared * squared);
        }
        double row = 0.0;
        for (std::size_t b = 0; b < points; ++b) row += terms[b];
        sum += wi[a] * row;
    }
    return s.areas[i] * s.areas[j] * sum / pi;
}

PairExchange::Pair PairExchange::precise(std::uint32_t i, std::uint32_t j) const {
    const Surfels& s = scene_.surfels;
    const double extent = std::max(extent_[i], extent_[j]);
    const double ratio = length(s.positions[j] - s.positions[i]) / extent;
    // From there on the contour's terms cancel to less than the kernel gives; quadrature has none that do.
    constexpr double largest_ratio = 1e3;
    if (!points_.is_patch(i) || !points_.is_patch(j) || (ratio > largest_ratio && !face_wholly(i, j)))
        return (*this)(i, j);
    if (ratio <= far_ratio_ && !rise_above_each_other(i, j)) return {};
    // Errors of square patches, turned at random: 1e-14 where they touch, 1e-9 over a gap of a tenth of their edge, at
    // most 1e-9 of the kernel between points facing each other farther off.
    const bool cancels = ratio <= 8.0 || !face_wholly(i, j);
    const double g = ratio <= mid_ratio_ ? between_polygons(i, j, 32, Grading::steep)
                     : ratio <= 6.0      ? between_polygons(i, j, 6, Grading::plain)
                     : cancels           ? between_polygons(i, j, 4, Grading::plain)
                     : ratio <= 20.0     ? by_quadrature<4>(i, j)
                                         : by_quadrature<3>(i, j);
    const double least = std::min(s.areas[i], s.areas[j]);
    const Range range = ratio <= mid_ratio_ ? Range::near : ratio <= far_ratio_ ? Range::mid : Range::far;
    return g > (cancels ? 1e-12 * least : 0.0) ? Pair{std::min(g, least), range} : Pair{};
}

double PairExchange::self(std::uint32_t i, const std::vector<std::uint32_t>& overlapping) const {
    const Surfels& s = scene_.surfels;
    double sum = 0.0;
    int counted = 0;
    for (std::uint32_t j : overlapping) {
        const double squared = length_squared(s.positions[j] - s.positions[i]);
        if (j == i || squared < 0.04 * s.radii[i] * s.radii[i] || !same_surface(i, j, squared)) continue;
        sum += kernel(s.positions[i], s.normals[i], s.positions[j], s.normals[j]);
        ++counted;
    }
    return counted == 0 ? 0.0 : std::min(s.areas[i] * s.areas[i] * sum / counted, 0.5 * s.areas[i]);
}

bool PairExchange::meets(std::uint32_t j, const Vec3& from, const Vec3& direction, Vec3& at) const {
    const Vec3& n = scene_.surfels.normals[j];
    const double approach = -dot(direction, n);
    const double height = dot(from - scene_.surfels.positions[j], n);
    if (approach <= 0.0 || height < 0.0) return false;
    at = from + (height / approach) * direction;
    if (!points_.is_patch(j)) return length_squared(at - scene_.surfels.positions[j]) <= extent_[j] * extent_[j];
    for (const Triangle* t = points_.triangles_begin(j); t != points_.triangles_end(j); ++t)
        if (dot(cross(t->b - t->a, at - t->a), n) >= 0.0 && dot(cross(t->c - t->b, at - t->b), n) >= 0.0 &&
            dot(cross(t->a - t->c, at - t->c), n) >= 0.0)
            return true;
    return false;
}

Vec3 PairExchange::ray_point(std::uint32_t i, Range range, double s, double t) const {
    if (points_.is_patch(i) || range != Range::near) return points_.at(i, s, t);
    const Frame frame = frame_around(scene_.surfels.normals[i]);
    double x, y;
    square_to_disk(s, t, x, y);
    return scene_.surfels.positions[i] + (within_cell * extent_[i]) * (x * frame.u + y * frame.v);
}

}  // namespace surflux
