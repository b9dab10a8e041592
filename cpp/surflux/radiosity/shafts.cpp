#include "surflux/radiosity/shafts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surflux/core/morton.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/scene/extent.h"

namespace surflux {

namespace {

constexpr std::size_t leaf = 2;  // surfels

}  // namespace

Shafts::Shafts(const Scene& scene) : surfels_(scene.surfels), triangles_(triangle_ranges(scene.surfels)) {
    const Surfels& s = surfels_;
    boxes_.resize(s.size());
    for (std::size_t i = 0; i < s.size(); ++i) {
        Box box{s.positions[i], s.positions[i]};
        const auto grow = [&](const Vec3& p, const Vec3& by) {
            for (int axis = 0; axis < 3; ++axis) {
                box.low[axis] = std::min(box.low[axis], p[axis] - by[axis]);
                box.high[axis] = std::max(box.high[axis], p[axis] + by[axis]);
            }
        };
        for (std::uint32_t t = triangles_[i]; t < triangles_[i + 1]; ++t)
            for (const Vec3& corner : {s.triangles[t].a, s.triangles[t].b, s.triangles[t].c}) grow(corner, {});
        if (triangles_[i] == triangles_[i + 1]) {
            const Vec3& n = s.normals[i];
            // Of the disk that blocks, and of that of its area, which light leaves.
            const double radius = std::max(s.radii[i], std::sqrt(s.areas[i] / pi));
            const auto reach = [&](double along) { return radius * std::sqrt(std::max(0.0, 1.0 - along * along)); };
            grow(s.positions[i], {reach(n.x), reach(n.y), reach(n.z)});
        }
        boxes_[i] = box;
    }
    // Embree's floats are off by 1e-7 of the scene; rays keep farther off than that. Where a few surfels are far away,
    // of the scene without them: in a shaft too wide there are more rays than it takes.
    touching_ = 1e-7 * Extent(s).size;
    find_blockers();
    nodes_.resize(4 * order_.size() + 4);
    if (!order_.empty()) bound(0, 0, order_.size());
}

void Shafts::find_blockers() {
    const Surfels& s = surfels_;
    std::vector<char> blocks(s.size(), 0);
    parallel_for(s.size(), 64, [&](std::size_t k) {
        const Vec3& n = s.normals[k];
        const double plane = dot(n, s.positions[k]);
        bool before = false, behind = false;
        for (std::uint32_t i = 0; i < s.size() && !(before && behind); ++i) {
            const Span at = span(i, n);
            before |= at.high > plane + touching_;
            behind |= at.low < plane - touching_;
        }
        blocks[k] = before && behind;
    });
    for (const std::uint32_t k : morton_order(s.positions))
        if (blocks[k]) order_.push_back(k);
}

void Shafts::bound(std::size_t node, std::size_t begin, std::size_t end) {
    Box box = boxes_[order_[begin]];
    for (std::size_t k = begin; k < end; ++k)
        for (int axis = 0; axis < 3; ++axis) {
            box.low[axis] = std::min(box.low[axis], boxes_[order_[k]].low[axis]);
            box.high[axis] = std::max(box.high[axis], boxes_[order_[k]].high[axis]);
        }
    nodes_[node] = box;
    if (end - begin <= leaf) return;
    const std::size_t middle = begin + (end - begin) / 2;
    bound(2 * node + 1, begin, middle);
    bound(2 * node + 2, middle, end);
}

Shafts::Shaft Shafts::between(std::uint32_t i, std::uint32_t j) const {
    Shaft shaft;
    const Box &a = boxes_[i], &b = boxes_[j];
    for (int axis = 0; axis < 3; ++axis) {
        shaft.bounds.low[axis] = std::min(a.low[axis], b.low[axis]) + touching_;
        shaft.bounds.high[axis] = std::max(a.high[axis], b.high[axis]) - touching_;
    }
    const auto add = [&](const Vec3& normal, double limit) {
        shaft.planes[shaft.count++] = {normal, limit - touching_};
    };
    for (const std::uint32_t end : {i, j}) {
        const Vec3& n = surfels_.normals[end];
        add(-n, -dot(n, surfels_.positions[end]));
    }
    // Seen along each axis: a line through the same corner of both rectangles bounds both, if its normal points to that
    // corner.
    for (int u = 0; u < 3; ++u) {
        const int v = (u + 1) % 3;
        for (const int side_u : {-1, 1})
            for (const int side_v : {-1, 1}) {
                const double au = side_u > 0 ? a.high[u] : a.low[u], av = side_v > 0 ? a.high[v] : a.low[v];
                const double bu = side_u > 0 ? b.high[u] : b.low[u], bv = side_v > 0 ? b.high[v] : b.low[v];
                const double du = bu - au, dv = bv - av, size = std::hypot(du, dv);
                // Parallel to an axis, the bounds say the same.
                if (du == 0.0 || dv == 0.0) continue;
                double nu = dv / size, nv = -du / size;
                if (nu * side_u < 0.0) nu = -nu, nv = -nv;
                if (nv * side_v < 0.0) continue;
                Vec3 normal;
                normal[u] = nu;
                normal[v] = nv;
                add(normal, nu * au + nv * av);
            }
    }
    return shaft;
}

bool Shafts::is_outside(const Box& box, const Shaft& shaft) {
    for (int axis = 0; axis < 3; ++axis)
        if (box.low[axis] >= shaft.bounds.high[axis] || box.high[axis] <= shaft.bounds.low[axis]) return true;
    for (std::size_t k = 0; k < shaft.count; ++k) {
        const Plane& plane = shaft.planes[k];
        double least = 0.0;
        for (int axis = 0; axis < 3; ++axis)
            least += plane.normal[axis] * (plane.normal[axis] > 0.0 ? box.low[axis] : box.high[axis]);
        if (least >= plane.limit) return true;
    }
    return false;
}

Shafts::Span Shafts::span(std::uint32_t surfel, const Vec3& direction) const {
    const Surfels& s = surfels_;
    if (triangles_[surfel] == triangles_[surfel + 1]) {
        const double along = dot(direction, s.normals[surfel]), middle = dot(direction, s.positions[surfel]);
        const double reach = s.radii[surfel] * std::sqrt(std::max(0.0, 1.0 - along * along));
        return {middle - reach, middle + reach};
    }
    Span out{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (std::uint32_t t = triangles_[surfel]; t < triangles_[surfel + 1]; ++t)
        for (const Vec3& corner : {s.triangles[t].a, s.triangles[t].b, s.triangles[t].c}) {
            out.low = std::min(out.low, dot(direction, corner));
            out.high = std::max(out.high, dot(direction, corner));
        }
    return out;
}

bool Shafts::is_outside(std::uint32_t surfel, const Shaft& shaft, std::uint32_t i, std::uint32_t j) const {
    if (is_outside(boxes_[surfel], shaft)) return true;
    // Both ends on one side of it, as everything is in a convex room.
    const Vec3& n = surfels_.normals[surfel];
    const Span at_i = span(i, n), at_j = span(j, n);
    const double plane = dot(n, surfels_.positions[surfel]);
    if (std::min(at_i.low, at_j.low) >= plane - touching_ || std::max(at_i.high, at_j.high) <= plane + touching_)
        return true;
    // Its corners, which reach less far than those of its box.
    for (std::size_t k = 0; k < shaft.count; ++k)
        if (span(surfel, shaft.planes[k].normal).low >= shaft.planes[k].limit) return true;
    return false;
}

// True where something may be inside.
bool Shafts::visit(std::size_t node, std::size_t begin, std::size_t end, const Shaft& shaft, std::uint32_t i,
                   std::uint32_t j) const {
    if (is_outside(nodes_[node], shaft)) return false;
    if (end - begin <= leaf) {
        for (std::size_t k = begin; k < end; ++k)
            if (order_[k] != i && order_[k] != j && !is_outside(order_[k], shaft, i, j)) return true;
        return false;
    }
    const std::size_t middle = begin + (end - begin) / 2;
    return visit(2 * node + 1, begin, middle, shaft, i, j) || visit(2 * node + 2, middle, end, shaft, i, j);
}

bool Shafts::empty(std::uint32_t i, std::uint32_t j) const {
    return order_.empty() || !visit(0, 0, order_.size(), between(i, j), i, j);
}

}  // namespace surflux
