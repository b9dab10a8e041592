#include "surflux/neighbors/tangent_cell.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/sampling.h"

namespace surflux {

namespace {

// Of the triangle of the centre 0, p and q: how far its part that is nearest to 0 reaches. In an acute triangle, to the
// circumcentre. Else that lies outside, and the part ends where bisectors leave through the side across from the
// obtuse corner.
double reach_in_triangle(double px, double py, double qx, double qy, double corner) {
    const double pp = px * px + py * py, qq = qx * qx + qy * qy, pq = px * qx + py * qy;
    if (pq <= 0.0) return 0.5 * std::sqrt(pp + qq - 2.0 * pq) * std::max(pp / (pp - pq), qq / (qq - pq));
    if (pq > pp) return 0.5 * pp * std::sqrt(qq) / pq;
    if (pq > qq) return 0.5 * qq * std::sqrt(pp) / pq;
    return corner;
}

}  // namespace

void TangentCell::start(const Vec3& center, const Vec3& normal, double limit) {
    center_ = center;
    frame_ = frame_around(normal);
    farthest_ = limit;
    corners_.clear();
    for (int k = 0; k < 8; ++k) {
        const double angle = 0.25 * pi * k;
        corners_.push_back({limit * std::cos(angle), limit * std::sin(angle), 0.0, 0.0, false});
    }
}

void TangentCell::cut(const Vec3& neighbor, bool crease, bool open) {
    const Vec3 d = neighbor - center_;
    const double x = dot(d, frame_.u), y = dot(d, frame_.v);
    const double flat = x * x + y * y;
    // The bisector's line in the plane is half |n| away, along n.
    const double turned = length_squared(d) / flat;
    const double nx = turned * x, ny = turned * y, half = 0.5 * (nx * nx + ny * ny);
    if (!(half < 1e300)) return;
    const auto beyond = [&](const Corner& c) { return c.x * nx + c.y * ny - half; };
    if (std::none_of(corners_.begin(), corners_.end(), [&](const Corner& c) { return beyond(c) > 0.0; })) return;
    cut_.clear();
    farthest_ = 0.0;
    const auto keep = [&](const Corner& c) {
        cut_.push_back(c);
        farthest_ = std::max(farthest_, c.x * c.x + c.y * c.y);
    };
    for (std::size_t k = 0; k < corners_.size(); ++k) {
        const Corner &a = corners_[k], &b = corners_[k + 1 < corners_.size() ? k + 1 : 0];
        const double fa = beyond(a), fb = beyond(b);
        if (fa <= 0.0) keep(a);
        if ((fa <= 0.0) == (fb <= 0.0)) continue;
        const double t = fa / (fa - fb);
        const Corner at{a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.nx, a.ny, a.crease};
        keep(fa <= 0.0 ? Corner{at.x, at.y, open ? 0.0 : nx, open ? 0.0 : ny, crease} : at);
    }
    farthest_ = std::sqrt(farthest_);
    std::swap(corners_, cut_);
}

double TangentCell::covering_radius(double border) const {
    double radius = 0.0;
    for (std::size_t k = 0; k < corners_.size(); ++k) {
        const Corner &before = corners_[k > 0 ? k - 1 : corners_.size() - 1], &c = corners_[k];
        const double p = std::hypot(before.nx, before.ny), q = std::hypot(c.nx, c.ny);
        const double corner = std::hypot(c.x, c.y);
        if (p > 0.0 && q > 0.0 && (before.crease || c.crease))
            radius = std::max(radius, corner);
        else if (p > 0.0 && q > 0.0 && corner <= border)
            radius = std::max(radius, reach_in_triangle(before.nx, before.ny, c.nx, c.ny, corner));
        else if (const double half_way = 0.5 * (p > 0.0 && q > 0.0 ? std::min(p, q) : std::max(p, q));
                 half_way <= border)
            radius = std::max(radius, half_way);
    }
    return radius;
}

}  // namespace surflux
