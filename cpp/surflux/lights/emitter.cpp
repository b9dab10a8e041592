#include "surflux/lights/emitter.h"

#include <algorithm>
#include <cmath>

#include "surflux/core/gauss_legendre.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/polygon.h"
#include "surflux/lights/spot_patch.h"

namespace surflux {

namespace {

constexpr int points_of_patch = 64, points_of_part = 16, patch_order = 4;
constexpr double close = 4.0;  // times the radius of what is lit, below which light may change much on it

struct PointEmitter : Emitter {
    explicit PointEmitter(const PointLight& light) : position(light.position) { color = light.intensity; }
    Arrival arrival(const Vec3& point, const Vec3& normal, double, double) const override {
        const Vec3 d = position - point;
        const double squared = length_squared(d);
        const double facing = dot(normal, d);
        if (squared == 0.0 || facing <= 0.0) return {position, 0.0};
        return {position, share(-d) * facing / (squared * std::sqrt(squared))};
    }
    double kernel_at(const Vec3& point, const Vec3& normal) const final { return arrival(point, normal, 0, 0).kernel; }
    // The integral of cos / r^2 over a patch is its solid angle.
    double mean_kernel(const Receiver& r) const final {
        if (!r.is_patch()) return kernel_at(r.center, r.normal);
        if (dot(r.normal, position - r.center) <= 0.0) return 0.0;
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
    // Of the intensity, what goes along a direction, and its integral over those to a triangle.
    virtual double share(const Vec3&) const { return 1.0; }
    virtual double power(const Triangle& t) const { return solid_angle(position, t); }
    Vec3 position;
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
    Vec3 towards_light;
};

struct AreaEmitter final : Emitter {
    explicit AreaEmitter(const AreaLight& light) : light_(light), front_(cross(light.edge_u, light.edge_v)) {
        color = light.exitance;
        extended = true;
        gauss_legendre(patch_order, rule_.at, rule_.weight);
    }
    Arrival arrival(const Vec3& point, const Vec3& normal, double s, double t) const override {
        const Vec3 from = light_.corner + s * light_.edge_u + t * light_.edge_v;
        const Vec3 d = from - point;
        const double squared = length_squared(d);
        if (squared == 0.0) return {from, 0.0};
        return {from, std::max(0.0, dot(normal, d)) * std::max(0.0, -dot(front_, d)) / (pi * squared * squared)};
    }
    double kernel_at(const Vec3& point, const Vec3& normal) const override {
        if (dot(point - light_.corner, front_) <= 0.0) return 0.0;
        const Vec3 corners[4] = {light_.corner, light_.corner + light_.edge_u,
                                 light_.corner + light_.edge_u + light_.edge_v, light_.corner + light_.edge_v};
        return element_to_polygon(point, normal, corners, 4);
    }
    bool is_even_in(const Vec3& center, double radius) const override {
        const Vec3 d = center - light_.corner;  // to the nearest point of the light, were its edges at right angles
        const auto along = [&](const Vec3& edge) { return std::clamp(dot(d, edge) / length_squared(edge), 0.0, 1.0); };
        const Vec3 nearest = d - along(light_.edge_u) * light_.edge_u - along(light_.edge_v) * light_.edge_v;
        return length_squared(nearest) > close * close * radius * radius;
    }
    // In closed form over the light, by points over a patch, for which no ray is traced; the other way round, by
    // reciprocity, where the light is the smaller of the two: close to it, points of the patch would miss it.
    double mean_kernel(const Receiver& r) const override {
        if (!r.is_patch()) return kernel_at(r.center, r.normal);
        const double area = r.points.area(r.shape);
        if (length(front_) < area && is_before(r)) return mean_from_light(r) * length(front_) / area;
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
    // Is all of the light on the front of the patch?
    bool is_before(const Receiver& r) const {
        const double middle = dot(r.normal, light_.corner + 0.5 * (light_.edge_u + light_.edge_v) - r.center);
        return middle > 0.5 * (std::abs(dot(r.normal, light_.edge_u)) + std::abs(dot(r.normal, light_.edge_v)));
    }
    // Mean form factor from points of the light to the patch.
    double mean_from_light(const Receiver& r) const {
        const Vec3 normal = normalized(front_);
        double sum = 0.0;
        for (const Triangle* t = r.points.triangles_begin(r.shape); t != r.points.triangles_end(r.shape); ++t) {
            const Vec3 corners[3] = {t->a, t->b, t->c};
            for (std::size_t a = 0; a < rule_.at.size(); ++a)
                for (std::size_t b = 0; b < rule_.at.size(); ++b)
                    sum += rule_.weight[a] * rule_.weight[b] *
                           element_to_polygon(light_.corner + rule_.at[a] * light_.edge_u + rule_.at[b] * light_.edge_v,
                                              normal, corners, 3);
        }
        return sum;
    }
    const AreaLight& light_;
    Vec3 front_;
    struct {
        std::vector<double> at, weight;
    } rule_;
};

}  // namespace

std::vector<std::unique_ptr<Emitter>> emitters_of(const std::vector<Light>& lights) {
    std::vector<std::unique_ptr<Emitter>> out;
    for (const Light& light : lights) {
        const std::size_t known = out.size();
        if (const auto* p = std::get_if<PointLight>(&light)) out.push_back(std::make_unique<PointEmitter>(*p));
        if (const auto* p = std::get_if<SpotLight>(&light)) out.push_back(std::make_unique<SpotEmitter>(*p));
        if (const auto* p = std::get_if<AreaLight>(&light)) out.push_back(std::make_unique<AreaEmitter>(*p));
        if (const auto* p = std::get_if<DirectionalLight>(&light))
            out.push_back(std::make_unique<DirectionalEmitter>(*p));
        if (out.size() > known) out.back()->index = static_cast<std::size_t>(&light - lights.data());
    }
    return out;
}

}  // namespace surflux
