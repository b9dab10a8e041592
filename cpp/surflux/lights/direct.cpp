#include "surflux/lights/direct.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/lights/polygon.h"
#include "surflux/lights/sample_points.h"

namespace surflux {

namespace {

constexpr std::uint64_t light_stream = 16;

// Each light gives, for a point of the light (s, t): where it stands, and what arrives unoccluded at `point`; and for
// the whole light the unoccluded irradiance at a point with a normal.
struct Arrival {
    Vec3 from;            // where the shadow ray ends; a direction towards the light where `distant`
    double weight = 0.0;  // irradiance per unit of `color`
};

struct Emitter {
    virtual ~Emitter() = default;
    virtual Arrival arrival(const Vec3& point, const Vec3& normal, double s, double t) const = 0;
    virtual double unoccluded(const Vec3& point, const Vec3& normal) const {
        return arrival(point, normal, 0.5, 0.5).weight;
    }
    Rgb color;
    bool distant = false;
    bool extended = false;  // more than one point
};

double smoothstep(double x) {
    x = std::clamp(x, 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

struct PointEmitter : Emitter {
    explicit PointEmitter(const PointLight& light) : position(light.position) { color = light.intensity; }
    Arrival arrival(const Vec3& point, const Vec3& normal, double, double) const override {
        const Vec3 d = position - point;
        const double squared = length_squared(d);
        if (squared == 0.0) return {position, 0.0};
        return {position, std::max(0.0, dot(normal, d)) / (squared * std::sqrt(squared)) * towards(-d)};
    }
    virtual double towards(const Vec3&) const { return 1.0; }
    Vec3 position;
};

struct SpotEmitter final : PointEmitter {
    explicit SpotEmitter(const SpotLight& light)
        : PointEmitter({light.position, light.intensity}),
          axis(light.direction),
          outer(light.cone * pi / 360.0),
          inner(std::max(0.0, light.cone - light.penumbra) * pi / 360.0) {}
    // Full within half of (cone - penumbra) of the axis, 0 from half of the cone on, smoothstep in angle between.
    double towards(const Vec3& d) const override {
        const double angle = std::atan2(length(cross(d, axis)), dot(d, axis));
        if (angle >= outer) return 0.0;
        return outer > inner ? smoothstep((outer - angle) / (outer - inner)) : 1.0;
    }
    Vec3 axis;
    double outer, inner;
};

struct DirectionalEmitter final : Emitter {
    explicit DirectionalEmitter(const DirectionalLight& light) : towards_light(-light.direction) {
        color = light.irradiance;
        distant = true;
    }
    Arrival arrival(const Vec3&, const Vec3& normal, double, double) const override {
        return {towards_light, std::max(0.0, dot(normal, towards_light))};
    }
    Vec3 towards_light;
};

struct AreaEmitter final : Emitter {
    explicit AreaEmitter(const AreaLight& light) : light_(light), front_(cross(light.edge_u, light.edge_v)) {
        color = light.exitance;
        extended = true;
    }
    Arrival arrival(const Vec3& point, const Vec3& normal, double s, double t) const override {
        const Vec3 from = light_.corner + s * light_.edge_u + t * light_.edge_v;
        const Vec3 d = from - point;
        const double squared = length_squared(d);
        if (squared == 0.0) return {from, 0.0};
        const double weight = std::max(0.0, dot(normal, d)) * std::max(0.0, -dot(front_, d)) / (pi * squared * squared);
        return {from, weight};
    }
    double unoccluded(const Vec3& point, const Vec3& normal) const override {
        if (dot(point - light_.corner, front_) <= 0.0) return 0.0;
        const Vec3 corners[4] = {light_.corner, light_.corner + light_.edge_u,
                                 light_.corner + light_.edge_u + light_.edge_v, light_.corner + light_.edge_v};
        return element_to_polygon(point, normal, corners, 4);
    }
    const AreaLight& light_;
    Vec3 front_;
};

std::vector<std::unique_ptr<Emitter>> emitters_of(const std::vector<Light>& lights) {
    std::vector<std::unique_ptr<Emitter>> out;
    for (const Light& light : lights) {
        if (const auto* p = std::get_if<PointLight>(&light)) out.push_back(std::make_unique<PointEmitter>(*p));
        if (const auto* p = std::get_if<SpotLight>(&light)) out.push_back(std::make_unique<SpotEmitter>(*p));
        if (const auto* p = std::get_if<AreaLight>(&light)) out.push_back(std::make_unique<AreaEmitter>(*p));
        if (const auto* p = std::get_if<DirectionalLight>(&light))
            out.push_back(std::make_unique<DirectionalEmitter>(*p));
    }
    return out;
}

// Mean over the surfel of the irradiance from one light, per unit of its colour.
double irradiance_from(const Emitter& light, const Tracer& tracer, const SurfelPoints& points, std::uint32_t i,
                       const Vec3& center, const Vec3& normal, const DirectOptions& options, EvenPoints even) {
    const bool one_ray = !light.extended && !points.is_patch(i);
    double unoccluded = 0.0, reach = 0.0, visible = 0.0;
    bool some_free = false, some_blocked = false;
    int taken = 0;
    const auto take = [&](int count) {
        for (; taken < count; ++taken) {
            const double* u = even.next();
            const Vec3 at = points.is_patch(i) ? points.at(i, u[2], u[3]) : center;
            unoccluded += light.unoccluded(at, normal);
            const Arrival arrival = light.arrival(at, normal, u[0], u[1]);
            if (arrival.weight <= 0.0) continue;
            const bool free = light.distant ? tracer.escapes(i, at, arrival.from) : tracer.visible(i, at, arrival.from);
            (free ? some_free : some_blocked) = true;
            reach += arrival.weight;
            if (free) visible += arrival.weight;
        }
    };
    take(one_ray ? 1 : options.probes);
    if (some_free && some_blocked) take(options.rays);
    return reach > 0.0 ? unoccluded / taken * (visible / reach) : 0.0;
}

}  // namespace

std::vector<Rgb> direct_irradiance(const Scene& scene, const Tracer& tracer, const DirectOptions& options,
                                   std::uint64_t seed, const Progress& progress) {
    const Surfels& s = scene.surfels;
    const SurfelPoints points(s);
    const auto lights = emitters_of(scene.lights);
    std::vector<Rgb> direct(s.size());
    if (lights.empty()) return direct;
    parallel_blocks(
        s.size(), 16,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const auto i = static_cast<std::uint32_t>(k);
                for (std::size_t l = 0; l < lights.size(); ++l)
                    direct[i] += irradiance_from(*lights[l], tracer, points, i, s.positions[i], s.normals[i], options,
                                                 EvenPoints(4, seed + light_stream + l, i)) *
                                 lights[l]->color;
            }
        },
        progress);
    return direct;
}

}  // namespace surflux
