#include "surflux/lights/spot_patch.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/clip_polygon.h"
#include "surflux/core/gauss_legendre.h"
#include "surflux/lights/polygon.h"

namespace surflux {

namespace {

constexpr double precision = 1e-9;  // of the power, that the rule brings
constexpr double small = 1e-5;      // of the power, what a triangle has at most that is too small for that
constexpr double far = 0.01;        // of its distance, what the longest side of such a triangle has at most
constexpr int rows = 16;            // of the parts of such a triangle, where the penumbra is no wider
constexpr int order = 8;            // of the rule along a piece of an edge
constexpr int sides = 16;           // of the pyramid: 1.3 % larger than the cone

using Polygon = std::vector<Vec3>;

// The part of a convex polygon with dot(normal, p) <= 0.
void clip(Polygon& polygon, const Vec3& normal, Polygon& spare) {
    spare.clear();
    clip_polygon(
        polygon.data(), polygon.size(), normal, 0.0, [&](const Vec3& p) { spare.push_back(p); }, [](const Vec3&) {});
    polygon.swap(spare);
}

// Where along a + t (b - a), t in (0, 1), the angle to the axis is `angle`: rho^2 = (z tan angle)^2. Coordinates are
// along the axes of a frame whose n is that of the cone.
void add_crossings(const Vec3& a, const Vec3& b, double angle, std::vector<double>& out) {
    if (!(angle > 0.0 && angle < 0.5 * pi)) return;
    const Vec3 d = b - a;
    const double squared = std::tan(angle) * std::tan(angle);
    const double p = d.x * d.x + d.y * d.y - squared * d.z * d.z, q = a.x * d.x + a.y * d.y - squared * a.z * d.z,
                 r = a.x * a.x + a.y * a.y - squared * a.z * a.z;
    const double discriminant = q * q - p * r;
    if (discriminant < 0.0) return;
    // Both roots without cancellation.
    const double s = -(q + std::copysign(std::sqrt(discriminant), q));
    for (const double t : {s / p, r / s})
        if (t > 0.0 && t < 1.0) out.push_back(t);
}

// Of the half space around the axis, or around its opposite: the azimuth's integral of share up to an edge's angle,
// edge by edge (Stokes). With rho^2 dphi = (x dy - y dx) it is smooth where an edge passes close by the axis.
template <class Within>
double around_edges(const Polygon& polygon, const double (&kinks)[2], const Within& within) {
    static const auto rule = [] {
        std::pair<std::vector<double>, std::vector<double>> out;
        gauss_legendre(order, out.first, out.second);
        return out;
    }();
    double sum = 0.0;
    std::vector<double> at;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vec3 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
        const double turn = a.x * b.y - a.y * b.x;
        if (turn == 0.0) continue;
        at = {0.0, 1.0};
        for (const double kink : kinks) add_crossings(a, b, kink, at);
        // Halves where the edge is long beside its distance from the axis or the light: the integrand has poles there.
        const Vec3 d = b - a;
        const double flat = d.x * d.x + d.y * d.y;
        if (flat > 0.0) {
            const double nearest = -(a.x * d.x + a.y * d.y) / flat;
            const double width = std::abs(turn) / flat;
            for (double step = std::max(width, 1e-9); step < 2.0; step *= 2.0)
                for (const double t : {nearest - step, nearest + step})
                    if (t > 0.0 && t < 1.0) at.push_back(t);
            if (nearest > 0.0 && nearest < 1.0) at.push_back(nearest);
        }
        std::sort(at.begin(), at.end());
        for (std::size_t piece = 1; piece < at.size(); ++piece)
            for (std::size_t g = 0; g < rule.first.size(); ++g) {
                const double length = at[piece] - at[piece - 1], t = at[piece - 1] + length * rule.first[g];
                const Vec3 p = a + t * d;
                const double squared = p.x * p.x + p.y * p.y;
                if (squared > 0.0)
                    sum += length * rule.second[g] * turn / squared * within(std::atan2(std::sqrt(squared), p.z));
            }
    }
    return std::abs(sum);
}

double longest_side(const Triangle& t) { return std::max({length(t.b - t.a), length(t.c - t.a), length(t.c - t.b)}); }

// The mean share over a triangle that is far off beside its size. A penumbra that is far wider has a share that the
// middles of its edges tell.
double mean_share(const Vec3& light, const SpotCone& cone, const Triangle& t) {
    const Vec3 a = t.a - light, b = t.b - light, c = t.c - light;
    if (longest_side(t) < 0.01 * (cone.outer() - cone.inner()) * length(a))
        return (cone.share(a + b) + cone.share(b + c) + cone.share(c + a)) / 3.0;
    double sum = 0.0;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < 2 * (rows - i) - 1; ++j) {
            const double third = j % 2 == 0 ? 1.0 / 3.0 : 2.0 / 3.0;
            sum += cone.share(a + (i + third) / rows * (b - a) + (j / 2 + third) / rows * (c - a));
        }
    return sum / (rows * rows);
}

}  // namespace

double spot_power(const Vec3& light, const SpotCone& cone, const Triangle& triangle) {
    // Most triangles are all within the full intensity, or all outside of the cone.
    if (cone.outer() < 0.5 * pi) {
        double widest = 0.0;
        for (const Vec3* corner : {&triangle.a, &triangle.b, &triangle.c})
            widest = std::max(widest, cone.angle(*corner - light));
        if (widest <= cone.inner()) return solid_angle(light, triangle);
        const Vec3 center = (triangle.a + triangle.b + triangle.c) / 3.0 - light;
        double reach = 0.0;
        for (const Vec3* corner : {&triangle.a, &triangle.b, &triangle.c})
            reach = std::max(reach, length(*corner - light - center));
        const double distance = length(center);
        if (reach < distance && cone.angle(center) - std::asin(reach / distance) >= cone.outer()) return 0.0;
    }
    const double all = cone.within(pi), seen = solid_angle(light, triangle);
    if (seen < small * all && longest_side(triangle) < far * length(triangle.a - light))
        return seen * mean_share(light, cone, triangle);
    const Frame frame = frame_around(cone.axis());
    Polygon whole;
    for (const Vec3* corner : {&triangle.a, &triangle.b, &triangle.c}) {
        const Vec3 p = *corner - light;
        whole.push_back({dot(p, frame.u), dot(p, frame.v), dot(p, frame.n)});
    }
    Polygon front = whole, spare;
    clip(front, {0, 0, -1}, spare);
    double sum = 0.0;
    const double kinks[2] = {cone.inner(), cone.outer()};
    if (front.size() >= 3) sum += around_edges(front, kinks, [&](double angle) { return cone.within(angle); });
    // Off the cone, edges cancel but for that.
    if (cone.outer() <= 0.5 * pi) return sum > precision * all ? sum : 0.0;
    // What lies behind, by its angle from the opposite of the axis.
    clip(whole, {0, 0, 1}, spare);
    if (whole.size() < 3) return sum;
    for (Vec3& p : whole) p.z = -p.z;
    const double opposite[2] = {pi - cone.inner(), pi - cone.outer()};
    return sum + around_edges(whole, opposite, [&](double angle) { return all - cone.within(pi - angle); });
}

void append_lit(const Vec3& light, const SpotCone& cone, const Triangle& triangle, std::vector<Triangle>& out) {
    if (cone.outer() >= pi / 3.0) {
        out.push_back(triangle);
        return;
    }
    // The pyramid turns with the scene, so that rays do, too.
    Frame frame = frame_around(cone.axis());
    const Vec3 edge = triangle.b - triangle.a, across = edge - dot(edge, frame.n) * frame.n;
    if (length(across) > 0.1 * length(edge)) {
        frame.u = normalized(across);
        frame.v = cross(frame.n, frame.u);
    }
    Polygon polygon{triangle.a - light, triangle.b - light, triangle.c - light}, spare;
    for (int k = 0; k < sides && polygon.size() >= 3; ++k) {
        const double angle = 2.0 * pi * k / sides;
        const Vec3 outwards = std::cos(angle) * frame.u + std::sin(angle) * frame.v;
        clip(polygon, std::cos(cone.outer()) * outwards - std::sin(cone.outer()) * frame.n, spare);
    }
    for (std::size_t k = 2; k < polygon.size(); ++k)
        out.push_back({light + polygon[0], light + polygon[k - 1], light + polygon[k], triangle.surfel});
}

}  // namespace surflux
