#include "surflux/lights/emitter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "surflux/core/clip_polygon.h"
#include "surflux/core/gauss_legendre.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/photometric_web.h"
#include "surflux/lights/polygon.h"
#include "surflux/lights/spherical_triangle.h"
#include "surflux/lights/spot_patch.h"

namespace surflux {

namespace {

constexpr int points_of_patch = 64, points_of_part = 16, patch_order = 4;
// Less of a wide light is a strip, or seen edge on: its corners lose their digits.
constexpr double least_solid_angle = 1e-6;
constexpr double touching = 1e-5;  // of a light, so much is nothing that its patch cuts off
constexpr double close = 4.0;      // times the radius of what is lit, below which light may change much on it

struct PointEmitter : Emitter {
    explicit PointEmitter(const PointLight& light) : position(light.position) { color = light.intensity; }
    Arrival arrival(const Vec3& point, const Vec3& normal, double, double) const override {
        const double even = even_kernel(point, normal);
        return {position, even > 0.0 ? share(point - position) * even : 0.0};
    }
    double kernel_at(const Vec3& point, const Vec3& normal) const final { return arrival(point, normal, 0, 0).kernel; }
    // Of one that shines alike all around.
    double even_kernel(const Vec3& point, const Vec3& normal) const {
        const Vec3 d = position - point;
        const double squared = length_squared(d), distance = std::sqrt(squared);
        const double facing = dot(normal, d);
        return facing <= no_height(position, point, distance) ? 0.0 : facing / (squared * distance);
    }
    // The integral of cos / r^2 over a patch is its solid angle.
    double mean_kernel(const Receiver& r) const final {
        if (!r.is_patch()) return kernel_at(r.center, r.normal);
        const Vec3 d = position - r.center;
        const double across = length(d) + std::sqrt(r.points.area(r.shape));
        if (dot(r.normal, d) <= no_height(position, r.center, across)) return 0.0;
        double sum = 0.0, area = 0.0;
        for (const Triangle* t = r.points.triangles_begin(r.shape); t != r.points.triangles_end(r.shape); ++t) {
            sum += power(*t);
            area += area_of(*t);
        }
        return sum / area;
    }
    bool is_even_in(const Vec3& center, double radius) const override {
        return length_squared(center - position) > close * close * radius * radius;
    }
    bool is_behind(const NormalCone& surfels) const final { return surfels.is_behind(position); }
    // Of the intensity, what goes along a direction, and its integral over those to a triangle.
    virtual double share(const Vec3&) const { return 1.0; }
    virtual double power(const Triangle& t) const { return solid_angle(position, t); }
    Vec3 position;
};

// For which nothing is asked by place.
struct EvenPointEmitter final : PointEmitter {
    using PointEmitter::PointEmitter;
    void kernels_at(const Vec3* points, const Vec3* normals, std::size_t count, double* out) const override {
        for (std::size_t k = 0; k < count; ++k) out[k] = even_kernel(points[k], normals[k]);
    }
};

struct SpotEmitter final : PointEmitter {
    explicit SpotEmitter(const SpotLight& light) : PointEmitter({light.position, light.intensity}), cone(light) {}
    double share(const Vec3& d) const override { return cone.share(d); }
    double power(const Triangle& t) const override { return spot_power(position, cone, t); }
    bool is_even_in(const Vec3& center, double radius) const override {
        const Vec3 d = center - position;
        const double distance = length(d);
        if (distance > radius && cone.angle(d) - std::asin(radius / distance) > cone.outer()) return true;
        const double beam = distance * std::tan(std::min(cone.outer(), 0.25 * pi));
        return PointEmitter::is_even_in(center, radius) && beam > close * radius;
    }
    void find_lit(const Receiver& r, std::vector<Triangle>& out) const override {
        for (const Triangle* t = r.points.triangles_begin(r.shape); t != r.points.triangles_end(r.shape); ++t)
            append_lit(position, cone, *t, out);
    }
    SpotCone cone;
};

struct PhotometricEmitter final : PointEmitter {
    explicit PhotometricEmitter(const PhotometricLight& light)
        : PointEmitter({light.position, light.intensity}), web(light) {}
    double share(const Vec3& d) const override { return web.share(d); }
    double power(const Triangle& t) const override { return web.power(position, t); }
    bool is_even_in(const Vec3& center, double radius) const override {
        const double beam = length(center - position) * std::tan(std::min(web.beam(), 0.25 * pi));
        return PointEmitter::is_even_in(center, radius) && beam > close * radius;
    }
    PhotometricWeb web;
};

struct DirectionalEmitter final : Emitter {
    explicit DirectionalEmitter(const DirectionalLight& light) : towards_light(-light.direction) {
        color = light.irradiance;
        distant = true;
    }
    Arrival arrival(const Vec3&, const Vec3& normal, double, double) const override {
        return {towards_light, std::max(0.0, dot(normal, towards_light))};
    }
    double kernel_at(const Vec3&, const Vec3& normal) const override {
        return std::max(0.0, dot(normal, towards_light));
    }
    double mean_kernel(const Receiver& r) const override { return kernel_at(r.center, r.normal); }
    bool is_even_in(const Vec3&, double) const override { return true; }
    bool is_behind(const NormalCone& surfels) const override {
        return dot(surfels.axis, towards_light) + surfels.spread < 0.0;
    }
    Vec3 towards_light;
};

struct AreaEmitter final : Emitter {
    explicit AreaEmitter(const AreaLight& light)
        : light_(light),
          front_(cross(light.edge_u, light.edge_v)),
          squared_width_(std::max(length_squared(light.edge_u), length_squared(light.edge_v))) {
        color = light.exitance;
        extended = true;
        gauss_legendre(patch_order, rule_.at, rule_.weight);
    }
    Arrival arrival(const Vec3& point, const Vec3& normal, double s, double t) const override {
        if (is_wide_at(point)) {
            const std::array<Triangle, 2> halves = halves_of_it();
            const double first = solid_angle(point, halves[0]), all = first + solid_angle(point, halves[1]);
            if (all > least_solid_angle) return arrival_of_solid_angle(point, normal, halves, first / all, all, s, t);
        }
        const Vec3 from = light_.corner + s * light_.edge_u + t * light_.edge_v;
        const Vec3 d = from - point;
        const double squared = length_squared(d);
        if (squared == 0.0) return {from, 0.0};
        return {from, std::max(0.0, dot(normal, d)) * std::max(0.0, -dot(front_, d)) / (pi * squared * squared)};
    }
    bool is_wide_at(const Vec3& point) const override {
        return is_lit(point) && squared_distance(point) < squared_width_;
    }
    double kernel_at(const Vec3& point, const Vec3& normal) const override {
        if (!is_lit(point)) return 0.0;
        const Vec3 corners[4] = {light_.corner, light_.corner + light_.edge_u,
                                 light_.corner + light_.edge_u + light_.edge_v, light_.corner + light_.edge_v};
        return element_to_polygon(point, normal, corners, 4);
    }
    bool is_even_in(const Vec3& center, double radius) const override {
        return squared_distance(center) > close * close * radius * radius;
    }
    // How far points are before surfels is convex in them: if its corners are behind, all is.
    bool is_behind(const NormalCone& surfels) const override {
        const Vec3 opposite = light_.corner + light_.edge_u + light_.edge_v;
        return surfels.is_behind(light_.corner) && surfels.is_behind(light_.corner + light_.edge_u) &&
               surfels.is_behind(light_.corner + light_.edge_v) && surfels.is_behind(opposite);
    }
    // In closed form over the light, by points over a patch, for which no ray is traced; the other way round, by
    // reciprocity, where the light is the smaller of the two: close to it, points of the patch would miss it.
    double mean_kernel(const Receiver& r) const override {
        if (!r.is_patch()) return kernel_at(r.center, r.normal);
        const double area = r.points.area(r.shape);
        if (length(front_) < area) return mean_from_light(r) / area;
        if (is_cut(r)) return mean_over_front(r) / area;
        double sum = 0.0;
        if (const SurfelPoints::Parallelogram* p = r.points.parallelogram(r.shape)) {
            for (std::size_t a = 0; a < rule_.at.size(); ++a)
                for (std::size_t b = 0; b < rule_.at.size(); ++b)
                    sum += rule_.weight[a] * rule_.weight[b] *
                           kernel_at(p->corner + rule_.at[a] * p->u + rule_.at[b] * p->v, r.normal);
            return sum;
        }
        EvenPoints even(2, 0, r.surfel);
        const int patch_points = r.is_whole_surfel ? points_of_patch : points_of_part;
        for (int k = 0; k < patch_points; ++k) {
            const double* u = even.next();
            sum += kernel_at(r.at(u[0], u[1]), r.normal);
        }
        return sum / patch_points;
    }

private:
    // Does a point lie before the light?
    bool is_lit(const Vec3& point) const {
        const double height = dot(point - light_.corner, front_) / length(front_);
        return height > no_height(point, light_.corner, std::sqrt(squared_width_));
    }
    // Its point that is nearest to another.
    Vec3 nearest(const Vec3& point) const {
        const Vec3 d = point - light_.corner;
        const auto along = [&](const Vec3& edge) { return std::clamp(dot(d, edge) / length_squared(edge), 0.0, 1.0); };
        return light_.corner + along(light_.edge_u) * light_.edge_u + along(light_.edge_v) * light_.edge_v;
    }
    double squared_distance(const Vec3& point) const { return length_squared(point - nearest(point)); }
    std::array<Triangle, 2> halves_of_it() const {
        const Vec3 a = light_.corner, b = a + light_.edge_u, c = b + light_.edge_v, d = a + light_.edge_v;
        return {{{a, b, c, 0}, {a, c, d, 0}}};
    }
    // By points of its area, the few that are near would carry nearly all.
    // `first`: the share of the first half in all of the solid angle.
    Arrival arrival_of_solid_angle(const Vec3& point, const Vec3& normal, const std::array<Triangle, 2>& halves,
                                   double first, double all, double s, double t) const {
        const bool second = s >= first;
        s = std::clamp(second ? (s - first) / (1.0 - first) : s / first, 0.0, 1.0);
        const Triangle& half = halves[second];
        const Vec3 way = square_to_spherical_triangle(normalized(half.a - point), normalized(half.b - point),
                                                      normalized(half.c - point), s, t);
        const double towards = -dot(way, front_);
        if (!(towards > 0.0)) return {nearest(point), 0.0};
        const Vec3 from = point + dot(point - light_.corner, front_) / towards * way;
        return {nearest(from), std::max(0.0, dot(normal, way)) * all / pi};  // where rounding has it beyond an edge
    }
    // Does the plane of the light go through a patch? The kernel has a step there, where the light touches it.
    bool is_cut(const Receiver& r) const {
        double lowest = 0.0, highest = 0.0;
        for (const Triangle* t = r.points.triangles_begin(r.shape); t != r.points.triangles_end(r.shape); ++t)
            for (const Vec3* corner : {&t->a, &t->b, &t->c}) {
                const double height = dot(*corner - light_.corner, front_);
                lowest = std::min(lowest, height), highest = std::max(highest, height);
            }
        return lowest < 0.0 && highest > 0.0;
    }
    // The integral over what of a patch lies before the light.
    double mean_over_front(const Receiver& r) const {
        double sum = 0.0;
        for (const Triangle* t = r.points.triangles_begin(r.shape); t != r.points.triangles_end(r.shape); ++t) {
            const Vec3 corners[3] = {t->a, t->b, t->c};
            Vec3 part[6];
            std::size_t n = 0;
            const auto keep = [&](const Vec3& p) { part[n++] = p; };
            clip_polygon(corners, 3, -front_, -dot(light_.corner, front_), keep, [](const Vec3&) {});
            for (std::size_t k = 1; k + 1 < n; ++k)
                sum += integral({part[0], part[k], part[k + 1], 0},
                                [&](const Vec3& at) { return kernel_at(at, r.normal); });
        }
        return sum;
    }
    // Over a triangle, by the rule of a square of which one side is drawn together (Duffy 1982).
    template <class Value>
    double integral(const Triangle& t, const Value& value) const {
        double sum = 0.0;
        for (std::size_t a = 0; a < rule_.at.size(); ++a)
            for (std::size_t b = 0; b < rule_.at.size(); ++b) {
                const Vec3 at = t.a + rule_.at[a] * (t.b - t.a + rule_.at[b] * (t.c - t.b));
                sum += 2.0 * rule_.at[a] * rule_.weight[a] * rule_.weight[b] * value(at);
            }
        return area_of(t) * sum;
    }
    // The integral over what of the light lies before a patch, of form factors to that.
    double mean_from_light(const Receiver& r) const {
        const Vec3 a = light_.corner, b = a + light_.edge_u, c = b + light_.edge_v, d = a + light_.edge_v;
        const Vec3 corners[4] = {a, b, c, d};
        Vec3 part[8];  // corners that the plane goes through may come more than once
        std::size_t n = 0;
        const double lowest = dot(r.normal, r.center) + no_height(r.center, a, std::sqrt(squared_width_));
        clip_polygon(corners, 4, -r.normal, -lowest, [&](const Vec3& p) { part[n++] = p; }, [](const Vec3&) {});
        const Vec3 normal = normalized(front_);
        const auto to_patch = [&](const Vec3& at) {
            double sum = 0.0;
            for (const Triangle* t = r.points.triangles_begin(r.shape); t != r.points.triangles_end(r.shape); ++t) {
                const Vec3 triangle[3] = {t->a, t->b, t->c};
                sum += element_to_polygon(at, normal, triangle, 3);
            }
            return sum;
        };
        double sum = 0.0, before = 0.0;
        for (std::size_t k = 1; k + 1 < n; ++k) before += area_of({part[0], part[k], part[k + 1], 0});
        if (before > (1.0 - touching) * length(front_)) {
            for (std::size_t i = 0; i < rule_.at.size(); ++i)
                for (std::size_t j = 0; j < rule_.at.size(); ++j)
                    sum += rule_.weight[i] * rule_.weight[j] *
                           to_patch(a + rule_.at[i] * light_.edge_u + rule_.at[j] * light_.edge_v);
            return length(front_) * sum;
        }
        for (std::size_t k = 1; k + 1 < n; ++k) sum += integral({part[0], part[k], part[k + 1], 0}, to_patch);
        return sum;
    }
    const AreaLight& light_;
    Vec3 front_;
    double squared_width_;
    struct {
        std::vector<double> at, weight;
    } rule_;
};

}  // namespace

std::vector<std::unique_ptr<Emitter>> emitters_of(const std::vector<Light>& lights) {
    std::vector<std::unique_ptr<Emitter>> out;
    for (const Light& light : lights) {
        const std::size_t known = out.size();
        if (const auto* p = std::get_if<PointLight>(&light)) out.push_back(std::make_unique<EvenPointEmitter>(*p));
        if (const auto* p = std::get_if<SpotLight>(&light)) out.push_back(std::make_unique<SpotEmitter>(*p));
        if (const auto* p = std::get_if<PhotometricLight>(&light))
            out.push_back(std::make_unique<PhotometricEmitter>(*p));
        if (const auto* p = std::get_if<AreaLight>(&light)) out.push_back(std::make_unique<AreaEmitter>(*p));
        if (const auto* p = std::get_if<DirectionalLight>(&light))
            out.push_back(std::make_unique<DirectionalEmitter>(*p));
        if (out.size() > known) out.back()->index = static_cast<std::size_t>(&light - lights.data());
    }
    return out;
}

}  // namespace surflux
