#include "surflux/render/bends.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/parallel.h"
#include "surflux/neighbors/point_index.h"
#include "surflux/render/principal_axes.h"

namespace surflux {

namespace {

constexpr std::size_t neighbors = 12;
constexpr double farthest = 3.0;  // radii
constexpr double steepest = 0.5;  // cosine: what faces farther away is another surface
constexpr double sharp = 0.8;     // cosine of 37 degrees, from which areas know an edge
constexpr double most = 0.7;      // of the radius times the curvature: a rim at 35 degrees

Bend fit(const Surfels& s, const std::vector<std::int32_t>& objects, std::uint32_t i,
         const std::vector<Neighbor>& near) {
    if (near.empty()) return {frame_around(s.normals[i]).u};
    const Frame frame = frame_around(s.normals[i]);
    const double reach = near.back().distance;
    Bend flat{frame.u};
    // Least squares for n_u = -(a x + b y), n_v = -(b x + c y): normal equations for (a, b, c).
    double xx = 0.0, xy = 0.0, yy = 0.0, ux = 0.0, uy_vx = 0.0, vy = 0.0, square = 0.0;
    for (const Neighbor& n : near) {
        const Vec3& normal = s.normals[n.index];
        const double facing = dot(normal, frame.n);
        if (objects[n.index] != objects[i]) continue;
        flat.sharp = flat.sharp || facing < sharp;
        if (n.distance == 0.0 || facing < steepest) continue;
        const Vec3 d = s.positions[n.index] - s.positions[i];
        const double x = dot(d, frame.u), y = dot(d, frame.v), t = n.distance / (1.01 * reach);
        const double u = dot(normal, frame.u) / facing, v = dot(normal, frame.v) / facing, w = (1.0 - t) * (1.0 - t);
        xx += w * x * x, xy += w * x * y, yy += w * y * y;
        ux -= w * u * x, uy_vx -= w * (u * y + v * x), vy -= w * v * y;
        square += w * (u * u + v * v);
    }
    // Two directions at least, or nothing is known.
    if (!(xx * yy - xy * xy > 1e-3 * (xx + yy) * (xx + yy)) || !(square > 0.0)) return flat;
    // | xx  xy      0  | a     ux
    // | xy  xx+yy   xy | b  =  uy + vx
    // | 0   xy      yy | c     vy
    const double sum = xx + yy, det = xx * (sum * yy - xy * xy) - xy * xy * yy;
    const double a = (ux * (sum * yy - xy * xy) - xy * (uy_vx * yy - xy * vy)) / det;
    const double b = (xx * (uy_vx * yy - xy * vy) - ux * xy * yy) / det;
    const double c = (xx * (sum * vy - xy * uy_vx) - xy * (xy * vy) + ux * xy * xy) / det;
    const double explained = std::clamp((a * ux + b * uy_vx + c * vy) / square, 0.0, 1.0);
    const PrincipalAxes axes = principal_axes(a, b, c);
    const double largest = most / s.radii[i];
    Bend bend = flat;
    bend.direction = axes.x * frame.u + axes.y * frame.v;
    bend.along = std::clamp(explained * axes.along, -largest, largest);
    bend.across = std::clamp(explained * axes.across, -largest, largest);
    return bend;
}

}  // namespace

std::vector<Bend> bends_of(const Surfels& surfels, const std::vector<std::int32_t>& objects,
                           const std::vector<std::uint32_t>& asked, const std::vector<std::uint32_t>& around) {
    std::vector<Bend> out(asked.size());
    if (asked.empty()) return out;
    std::vector<Vec3> places;
    for (const std::uint32_t i : around) places.push_back(surfels.positions[i]);
    const PointIndex index(places);
    parallel_blocks(asked.size(), 256, [&](std::size_t begin, std::size_t end) {
        std::vector<Neighbor> near;
        for (std::size_t k = begin; k < end; ++k) {
            index.nearest(surfels.positions[asked[k]], neighbors + 1, near, farthest * surfels.radii[asked[k]]);
            for (Neighbor& n : near) n.index = around[n.index];
            out[k] = fit(surfels, objects, asked[k], near);
        }
    });
    return out;
}

}  // namespace surflux
