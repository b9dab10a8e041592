#include "surflux/lights/close_lamps.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/sampling.h"
#include "surflux/lights/polygon.h"
#include "surflux/lights/spherical_triangle.h"

namespace surflux {

namespace {

// Less is a strip, or seen edge on: corners lose their digits.
constexpr double least_solid_angle = 1e-6;

// The radius of a patch around its centre; of what is none 0, to which no lamp is close.
double reach(const Receiver& receiver) {
    double squared = 0.0;
    if (receiver.is_patch())
        for (const Triangle* t = receiver.points.triangles_begin(receiver.shape);
             t != receiver.points.triangles_end(receiver.shape); ++t)
            for (const Vec3* corner : {&t->a, &t->b, &t->c})
                squared = std::max(squared, length_squared(*corner - receiver.center));
    return std::sqrt(squared);
}

bool is_close_to(const Receiver& receiver, double radius, const Emitter& lamp) {
    return radius > 0.0 && !lamp.distant && !lamp.is_even_in(receiver.center, radius);
}

// Of triangles, as seen from a point: solid angles up to and with each.
void add_up(const Vec3& eye, const std::vector<Triangle>& triangles, std::vector<double>& up_to) {
    up_to.clear();
    double sum = 0.0;
    for (const Triangle& t : triangles) up_to.push_back(sum += solid_angle(eye, t));
}

// A point of them, evenly over the solid angle.
Vec3 point_of(const Vec3& eye, const std::vector<Triangle>& triangles, const std::vector<double>& up_to, double s,
              double t) {
    const double chosen = s * up_to.back();
    const auto at = std::upper_bound(up_to.begin(), up_to.end() - 1, chosen);
    const double before = at == up_to.begin() ? 0.0 : at[-1];
    const Triangle& one = triangles[static_cast<std::size_t>(at - up_to.begin())];
    const Vec3 a = one.a - eye, b = one.b - eye, c = one.c - eye;
    const double along = *at > before ? std::clamp((chosen - before) / (*at - before), 0.0, 1.0) : 0.0;
    const Vec3 way = square_to_spherical_triangle(normalized(a), normalized(b), normalized(c), along, t);
    // way goes as the sum of the corners by their weights; rounding has some a hair beyond an edge.
    Vec3 w{dot(way, cross(b, c)), dot(way, cross(c, a)), dot(way, cross(a, b))};
    if (w.x + w.y + w.z < 0.0) w = -w;
    w = {std::max(0.0, w.x), std::max(0.0, w.y), std::max(0.0, w.z)};
    const double sum = w.x + w.y + w.z;
    return sum > 0.0 ? (w.x * one.a + w.y * one.b + w.z * one.c) / sum : (one.a + one.b + one.c) / 3.0;
}

}  // namespace

LampSamples::LampSamples(const Emitter& lamp, const Light& light, const Receiver& receiver)
    : lamp_(lamp), receiver_(receiver) {
    if (!is_close_to(receiver, reach(receiver), lamp)) return;
    patch_ = receiver.points.area(receiver.shape);
    lamp.find_lit(receiver, part_);
    if (part_.empty())
        part_.assign(receiver.points.triangles_begin(receiver.shape), receiver.points.triangles_end(receiver.shape));
    area_ = std::get_if<AreaLight>(&light);
    if (area_) {
        // A wider one has all that reaches a point in closed form, and its samples see the patch as one point.
        if (length(cross(area_->edge_u, area_->edge_v)) < patch_) how_ = by_light;
        return;
    }
    if (const auto* p = std::get_if<PointLight>(&light)) position_ = p->position;
    if (const auto* p = std::get_if<SpotLight>(&light)) position_ = p->position;
    if (const auto* p = std::get_if<PhotometricLight>(&light)) position_ = p->position;
    add_up(position_, part_, up_to_);
    if (up_to_.back() < least_solid_angle) return;
    how_ = by_solid_angle;
    mean_ = lamp.mean_kernel(receiver);
}

LampSample LampSamples::sample(const double* u) const {
    if (how_ == by_solid_angle) return over_solid_angle(u);
    if (how_ == by_light) return from_area(u);
    const Vec3 at = receiver_.at(u[2], u[3]);
    return {at, lamp_.arrival(at, receiver_.normal, u[0], u[1]), lamp_.kernel_at(at, receiver_.normal)};
}

// The kernel is cos / r^2 times what the lamp sends that way: over the solid angle, that alone.
LampSample LampSamples::over_solid_angle(const double* u) const {
    if (!(mean_ > 0.0)) return {};
    const Vec3 at = point_of(position_, part_, up_to_, u[2], u[3]);
    const Arrival there = lamp_.arrival(at, receiver_.normal, u[0], u[1]);
    const double facing = std::abs(dot(receiver_.normal, position_ - at)), distance = length(position_ - at);
    const double per_angle = facing > 0.0 ? there.kernel * distance * distance * distance / facing : 0.0;
    return {receiver_.points.inset(receiver_.shape, at), {position_, per_angle * up_to_.back() / patch_}, mean_};
}

// cos cos / (pi r^2), over the light and the solid angle from there.
LampSample LampSamples::from_area(const double* u) const {
    const Vec3 from = area_->corner + u[0] * area_->edge_u + u[1] * area_->edge_v;
    const Vec3 across = cross(area_->edge_u, area_->edge_v);
    const double size = length(across);
    const double width = std::sqrt(std::max(length_squared(area_->edge_u), length_squared(area_->edge_v)));
    if (dot(receiver_.normal, from - receiver_.center) <= no_height(receiver_.center, area_->corner, width)) return {};
    thread_local std::vector<double> up_to;
    add_up(from, part_, up_to);
    LampSample out{receiver_.at(u[2], u[3]), {from, 0.0}, 0.0};
    const Vec3 normal = across / size;
    for (const Triangle& t : part_) {
        const Vec3 corners[3] = {t.a, t.b, t.c};
        out.expected += size / patch_ * element_to_polygon(from, normal, corners, 3);
    }
    if (up_to.back() < least_solid_angle) return out;
    const Vec3 at = point_of(from, part_, up_to, u[2], u[3]);
    const double facing = dot(normal, normalized(at - from));
    out.at = receiver_.points.inset(receiver_.shape, at);
    out.arrival.kernel = std::max(0.0, facing) * up_to.back() * size / (pi * patch_);
    return out;
}

bool CloseLamps::any(const Receiver& receiver) const {
    if (lamps_.empty()) return false;
    const double radius = reach(receiver);
    return std::any_of(lamps_.begin(), lamps_.end(),
                       [&](const auto& lamp) { return is_close_to(receiver, radius, *lamp); });
}

}  // namespace surflux
