#include "surflux/area/pieces.h"

#include <algorithm>

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

}  // namespace surflux
