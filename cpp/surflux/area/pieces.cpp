#include "surflux/area/pieces.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

#include "surflux/core/clip_polygon.h"

namespace surflux {

namespace {

constexpr double rounding = 1e-12;  // of an edge's length: what overlaps by less touches
constexpr double shortest = 1e-3;   // edge that parts, over how wide its polygon is

double area_of(const Polygon& polygon) {
    Vec3 sum;
    for (std::size_t k = 2; k < polygon.size(); ++k) sum += cross(polygon[k - 1] - polygon[0], polygon[k] - polygon[0]);
    return 0.5 * length(sum);
}

// Does an edge of `of` part it from the other polygon, in the plane across `normal`? Edges that both have lie on it up
// to rounding; of edges that cutting left of corners, rounding is all there is.
bool parts(const Vec3* of, std::size_t count, const Vec3& normal, const Vec3* other, std::size_t others) {
    double widest = 0.0;
    for (std::size_t k = 1; k < count; ++k) widest = std::max(widest, length_squared(of[k] - of[0]));
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3 edge = of[(k + 1) % count] - of[k], outwards = cross(edge, normal);
        if (!(length_squared(edge) > shortest * shortest * widest)) continue;
        const double limit = -rounding * length_squared(edge);
        bool beyond = true;
        for (std::size_t c = 0; c < others && beyond; ++c) beyond = dot(outwards, other[c] - of[k]) >= limit;
        if (beyond) return true;
    }
    return false;
}

constexpr std::size_t few = 16;  // triangles that are taken from a cell one by one

// On either side of a plane.
struct Halves {
    Pieces low, high;
};

Halves halves_of(const Pieces& pieces, const Vec3& normal, double limit) {
    Halves out;
    Polygon in, off;
    for (const Polygon& piece : pieces) {
        in.clear(), off.clear();
        clip_polygon(
            piece.data(), piece.size(), normal, limit, [&](const Vec3& p) { in.push_back(p); },
            [&](const Vec3& p) { off.push_back(p); });
        if (in.size() >= 3) out.low.push_back(in);
        if (off.size() >= 3) out.high.push_back(off);
    }
    return out;
}

// take_in_turn, by cells.
class Taking {
public:
    Taking(const std::vector<Triangle>& triangles, const Vec3& origin, double low, double high,
           std::vector<double>& taken)
        : triangles_(triangles), origin_(origin), low_(low), high_(high), taken_(taken) {}

    // Gives what is left of the pieces by those of the triangles, ascending, that `of` numbers.
    double run(Pieces pieces, const std::vector<std::uint32_t>& of) {
        if (of.size() > few) {
            // Most are where their mean is, whatever a few large ones reach.
            Vec3 middle;
            for (const std::uint32_t t : of)
                middle += (triangles_[t].a + triangles_[t].b + triangles_[t].c) / 3.0 - origin_;
            middle = middle / static_cast<double>(of.size());
            std::vector<std::uint32_t> below, above, best_below, best_above;
            int best = -1;
            for (int axis = 0; axis < 3; ++axis) {
                split(of, axis, middle[axis], below, above);
                if (best >= 0 && below.size() + above.size() >= best_below.size() + best_above.size()) continue;
                best = axis;
                best_below = below, best_above = above;
            }
            // Else they lie over each other, or across all of it.
            if (4 * (best_below.size() + best_above.size()) <= 5 * of.size() &&
                std::max(best_below.size(), best_above.size()) < of.size()) {
                Vec3 normal;
                normal[best] = 1.0;
                Halves halves = halves_of(pieces, normal, middle[best]);
                double left = 0.0;
                if (!halves.low.empty()) left += run(std::move(halves.low), best_below);
                if (!halves.high.empty()) left += run(std::move(halves.high), best_above);
                return left;
            }
        }
        double left = surflux::area_of(pieces);
        for (const std::uint32_t t : of) {
            if (pieces.empty()) break;
            pieces = without(pieces, triangles_[t], origin_, low_, high_);
            const double now = surflux::area_of(pieces);
            taken_[triangles_[t].surfel] += left - now;
            left = now;
        }
        return left;
    }

private:
    // By the places that they may cover: no farther off, along their normals, than low or high.
    void split(const std::vector<std::uint32_t>& of, int axis, double middle, std::vector<std::uint32_t>& below,
               std::vector<std::uint32_t>& above) const {
        below.clear(), above.clear();
        const double margin = std::max(std::abs(low_), std::abs(high_)), at = middle + origin_[axis];
        for (const std::uint32_t t : of) {
            const Triangle& corners = triangles_[t];
            const auto [low, high] = std::minmax({corners.a[axis], corners.b[axis], corners.c[axis]});
            if (low - margin <= at) below.push_back(t);
            if (high + margin >= at) above.push_back(t);
        }
    }

    const std::vector<Triangle>& triangles_;
    const Vec3& origin_;
    const double low_, high_;
    std::vector<double>& taken_;
};

}  // namespace

Pieces pieces_of(const Triangle* begin, const Triangle* end, const Vec3& origin) {
    Pieces out;
    for (const Triangle* t = begin; t != end; ++t) out.push_back({t->a - origin, t->b - origin, t->c - origin});
    return out;
}

double area_of(const Pieces& pieces) {
    double sum = 0.0;
    for (const Polygon& piece : pieces) sum += area_of(piece);
    return sum;
}

Pieces without(const Pieces& pieces, const Triangle& t, const Vec3& origin, double low, double high) {
    const Vec3 corners[3] = {t.a - origin, t.b - origin, t.c - origin};
    const Vec3 normal = normalized(cross_of(t));
    Pieces out, rest;
    Polygon in, off;
    for (const Polygon& all : pieces) {
        // Separating axes: nearly all that are asked for lie beside each other.
        if (parts(corners, 3, normal, all.data(), all.size()) || parts(all.data(), all.size(), normal, corners, 3)) {
            out.push_back(all);
            continue;
        }
        Polygon piece = all;
        rest.clear();
        const auto cut = [&](const Vec3& n, double limit) {
            if (piece.size() < 3) return;
            in.clear(), off.clear();
            clip_polygon(
                piece.data(), piece.size(), n, limit, [&](const Vec3& p) { in.push_back(p); },
                [&](const Vec3& p) { off.push_back(p); });
            if (off.size() >= 3) rest.push_back(off);
            piece.swap(in);
        };
        for (int k = 0; k < 3; ++k) {
            const Vec3 outwards = normalized(cross(corners[(k + 1) % 3] - corners[k], normal));
            cut(outwards, dot(outwards, corners[k]));
        }
        const double height = dot(normal, corners[0]);
        cut(normal, height - low);
        cut(-normal, high - height);
        // A piece that the triangle does not reach stays whole.
        if (piece.size() < 3 || !(area_of(piece) > 0.0)) rest.assign(1, all);
        out.insert(out.end(), rest.begin(), rest.end());
    }
    return out;
}

double take_in_turn(const Pieces& pieces, const std::vector<Triangle>& triangles, const Vec3& origin, double low,
                    double high, std::vector<double>& taken) {
    std::vector<std::uint32_t> all(triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    return Taking(triangles, origin, low, high, taken).run(pieces, all);
}

}  // namespace surflux
