#include "surflux/render/kernel_walls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "surflux/core/error.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/render/joined_depth.h"
#include "surflux/render/reach.h"
#include "surflux/scene/box_tree.h"

namespace surflux {

namespace {

constexpr double widest = 1.2;    // kernels, over their reach: the filter of the picture widens them
constexpr double slit = 0.01;     // of the reach: how high over the plane walls are looked for
constexpr double blending = 0.5;  // cosine of normals from which on surfaces blend (kernel_fragment)
constexpr double turned = 0.87;   // and of those that face away: the other sides of a bowl's faces, not of a tent's

std::vector<Box> boxes_of(const std::vector<Triangle>& triangles) {
    std::vector<Box> out(triangles.size());
    parallel_for(out.size(), 4096, [&](std::size_t k) {
        const Triangle& t = triangles[k];
        for (int axis = 0; axis < 3; ++axis) {
            out[k].low[axis] = std::min({t.a[axis], t.b[axis], t.c[axis]});
            out[k].high[axis] = std::max({t.a[axis], t.b[axis], t.c[axis]});
        }
    });
    return out;
}

// Directions from the centre of a kernel, all around. A wall that is narrower than these are apart may be seen past.
constexpr int directions = 64;
constexpr double step = 2.0 * pi / directions;
constexpr double farthest = 4.0;  // reaches: where walls end at most

// A line in the plane of a kernel: `along` it, and how far from the centre it passes, to the left.
struct Line {
    double x, y, offset;
    // How far it is along a direction from the centre; infinity where it is not met.
    double distance(double angle) const {
        const double across = std::cos(angle) * y - std::sin(angle) * x;
        const double at = across != 0.0 ? offset / across : -1.0;
        return at > 0.0 ? at : std::numeric_limits<double>::infinity();
    }
    // Where it is met in a direction, no farther than so far along it from where it passes the centre.
    std::array<double, 2> end(double angle, double most) const {
        const double far = distance(angle), met = x * far * std::cos(angle) + y * far * std::sin(angle);
        const double at = std::abs(met) < std::abs(most) ? met : most;
        return {offset * y + at * x, -offset * x + at * y};
    }
};

// What is nearest in each direction.
class View {
public:
    explicit View(double reach) : reach_(reach) { distance_.fill(std::numeric_limits<double>::infinity()); }

    void add(double ax, double ay, double bx, double by) {
        const double length = std::hypot(bx - ax, by - ay), offset = (ax * by - ay * bx) / length;
        if (!(length > 0.0) || offset == 0.0) return;
        const Line line = offset > 0.0 ? Line{(bx - ax) / length, (by - ay) / length, offset}
                                       : Line{(ax - bx) / length, (ay - by) / length, -offset};
        const double from = offset > 0.0 ? std::atan2(ay, ax) : std::atan2(by, bx);
        double to = offset > 0.0 ? std::atan2(by, bx) : std::atan2(ay, ax);
        if (to < from) to += 2.0 * pi;
        const int first = static_cast<int>(std::ceil(from / step - 0.5 - margin));
        const int last = static_cast<int>(std::floor(to / step - 0.5 + margin));
        for (int k = first; k <= last; ++k) {
            const auto d = static_cast<std::size_t>((k % directions + directions) % directions);
            const double at = line.distance((k + 0.5) * step);
            if (!(at < distance_[d])) continue;
            distance_[d] = at;
            line_[d] = line;
            seen_ = seen_ || at < reach_;
        }
    }

    // Walls through what is seen, no gap between those side by side.
    void walls(std::vector<WallTrace>& out) const {
        if (!seen_) return;
        int start = 0;
        while (start < directions && joins(start, start + 1)) ++start;
        for (int first = start + 1, next; first <= start + directions; first = next) {
            next = first + 1;
            while (next <= start + directions && joins(first, next)) ++next;
            const Line& line = line_[at(first)];
            if (!(distance_[at(first)] < std::numeric_limits<double>::infinity())) continue;
            const auto [ax, ay] = line.end(first * step - overlap, -farthest * reach_);
            const auto [bx, by] = line.end(next * step + overlap, farthest * reach_);
            WallTrace wall{
                {static_cast<float>(ax), static_cast<float>(ay), static_cast<float>(bx), static_cast<float>(by)}};
            out.push_back(wall);
        }
    }

private:
    static constexpr double overlap = 1e-3;         // radians
    static constexpr double margin = 1e-6;          // of a step: what is met at the very end of a wall
    static constexpr double same_direction = 0.02;  // radians, and of the reach
    static std::size_t at(int direction) { return static_cast<std::size_t>(direction % directions); }
    bool joins(int a, int b) const {
        const bool has_a = std::isfinite(distance_[at(a)]), has_b = std::isfinite(distance_[at(b)]);
        if (has_a != has_b || !has_a) return has_a == has_b;
        const Line &one = line_[at(a)], &other = line_[at(b)];
        return std::abs(one.x * other.y - one.y * other.x) < same_direction &&
               one.x * other.x + one.y * other.y > 0.0 && std::abs(one.offset - other.offset) < same_direction * reach_;
    }

    double reach_;
    std::array<double, directions> distance_;
    std::array<Line, directions> line_ = {};
    bool seen_ = false;
};

// Those around a surfel that reaches so far.
void find_walls(const std::vector<Triangle>& triangles, const BoxTree& tree, const Vec3& center, const Vec3& normal,
                double reach, std::vector<WallTrace>& out) {
    const Frame frame = frame_around(normal);
    const double height = slit * reach;
    View view(reach);
    const auto meets = [&](const Box& box) {
        double far = 0.0, lowest = 0.0, highest = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
            const double low = box.low[axis] - center[axis], high = box.high[axis] - center[axis];
            const double beyond = std::max({low, -high, 0.0});
            far += beyond * beyond;
            lowest += std::min(normal[axis] * low, normal[axis] * high);
            highest += std::max(normal[axis] * low, normal[axis] * high);
        }
        return far <= reach * reach && lowest <= height && highest > height;
    };
    tree.visit(meets, [&](std::uint32_t k) {
        const Triangle& t = triangles[k];
        const Vec3 corners[3] = {t.a - center, t.b - center, t.c - center};
        double over[3];
        for (int c = 0; c < 3; ++c) over[c] = dot(normal, corners[c]) - height;
        if (std::max({over[0], over[1], over[2]}) <= 0.0 || std::min({over[0], over[1], over[2]}) > 0.0) return;
        const Vec3 span = cross_of(t);
        const double cosine = dot(span, normal) / length(span);
        if (!(cosine < blending && cosine > -turned)) return;
        Vec3 ends[2];
        int found = 0;
        for (int c = 0; c < 3; ++c) {
            const int next = (c + 1) % 3;
            if ((over[c] > 0.0) != (over[next] > 0.0))
                ends[found++] = corners[c] + over[c] / (over[c] - over[next]) * (corners[next] - corners[c]);
        }
        view.add(dot(ends[0], frame.u), dot(ends[0], frame.v), dot(ends[1], frame.u), dot(ends[1], frame.v));
    });
    view.walls(out);
}

}  // namespace

KernelWalls::KernelWalls(const Surfels& surfels, double footprint, const Progress& progress) {
    const std::size_t n = surfels.size();
    begin_.assign(n + 1, 0);
    depth_.assign(n, std::numeric_limits<float>::infinity());
    if (surfels.triangles.empty()) return;
    const BoxTree tree(boxes_of(surfels.triangles));
    const std::vector<Reach> reach = reaches(surfels);
    depth_ = joined_depths(surfels, tree, reach, progress);
    constexpr std::size_t grain = 1024;
    std::vector<std::vector<WallTrace>> found((n + grain - 1) / grain);
    const auto find = [&](std::size_t begin, std::size_t end) {
        std::vector<WallTrace>& of_block = found[begin / grain];
        for (std::size_t i = begin; i < end; ++i) {
            find_walls(surfels.triangles, tree, surfels.positions[i], surfels.normals[i],
                       widest * footprint * reach[i].along, of_block);
            begin_[i + 1] = static_cast<std::uint32_t>(of_block.size());
        }
    };
    parallel_blocks(n, grain, find, progress);
    std::size_t total = 0;
    for (const std::vector<WallTrace>& of_block : found) total += of_block.size();
    require(total <= std::numeric_limits<std::int32_t>::max(), "surfels: more than 2^31 walls between them");
    walls_.reserve(total);
    for (std::size_t b = 0; b < found.size(); ++b) {
        const auto before = static_cast<std::uint32_t>(walls_.size());
        for (std::size_t i = b * grain; i < std::min((b + 1) * grain, n); ++i) begin_[i + 1] += before;
        walls_.insert(walls_.end(), found[b].begin(), found[b].end());
        std::vector<WallTrace>().swap(found[b]);
    }
}

}  // namespace surflux
