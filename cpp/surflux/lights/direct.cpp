#include "surflux/lights/direct.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "surflux/core/gauss_legendre.h"
#include "surflux/core/parallel.h"
#include "surflux/core/sampling.h"
#include "surflux/core/thread_scratch.h"
#include "surflux/lights/narrow_light.h"
#include "surflux/lights/polygon.h"
#include "surflux/lights/sample_points.h"
#include "surflux/lights/spot_patch.h"

namespace surflux {

namespace {

constexpr std::uint64_t light_stream = 16;
constexpr int points_of_patch = 64, points_of_part = 16, patch_order = 4;
constexpr double evenness = 0.5;  // of even points' standard error in that of random ones, measured in penumbrae

// The surfel that is lit, as far as a light needs to know it.
struct Receiver {
    const SurfelPoints& points;
    std::uint32_t surfel, shape;
    Vec3 center, normal;
    bool is_whole_surfel;

    bool is_patch() const { return shape != Place::point && points.is_patch(shape); }
    Vec3 at(double s, double t) const { return is_patch() ? points.at(shape, s, t) : center; }
};

// What one point of a light sends to one point of a surfel.
struct Arrival {
    Vec3 from;            // where the shadow ray ends; the direction to the light where it is distant
    double kernel = 0.0;  // irradiance per unit of colour, unoccluded
};

struct Emitter {
    virtual ~Emitter() = default;
    // From the light's point (s, t).
    virtual Arrival arrival(const Vec3& point, const Vec3& normal, double s, double t) const = 0;
    // Mean of the kernel over the light and over the receiver.
    virtual double mean_kernel(const Receiver& receiver) const = 0;
    // Of a patch, the part that the light can shine on, where that may be little of it; else nothing.
    virtual void find_lit(const Receiver&, std::vector<Triangle>&) const {}
    Rgb color;
    bool distant = false;
    bool extended = false;  // more than one point
    std::size_t index = 0;  // in the scene's lights
};

struct PointEmitter : Emitter {
    explicit PointEmitter(const PointLight& light) : position(light.position) { color = light.intensity; }
    Arrival arrival(const Vec3& point, const Vec3& normal, double, double) const override {
        const Vec3 d = position - point;
        const double squared = length_squared(d);
        if (squared == 0.0) return {position, 0.0};
        return {position, share(-d) * std::max(0.0, dot(normal, d)) / (squared * std::sqrt(squared))};
    }
    // The integral of cos / r^2 over a patch is its solid angle.
    double mean_kernel(const Receiver& r) const final {
        if (!r.is_patch()) return arrival(r.center, r.normal, 0.5, 0.5).kernel;
        if (dot(r.normal, position - r.center) <= 0.0) return 0.0;
        double sum = 0.0, area = 0.0;
        for (const Triangle* t = r.points.triangles_begin(r.shape); t != r.points.triangles_end(r.shape); ++t) {
            sum += power(*t);
            area += area_of(*t);
        }
        return sum / area;
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
    double mean_kernel(const Receiver& r) const override { return std::max(0.0, dot(r.normal, towards_light)); }
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
    // In closed form over the light, by points over a patch, for which no ray is traced; the other way round, by
    // reciprocity, where the light is the smaller of the two: close to it, points of the patch would miss it.
    double mean_kernel(const Receiver& r) const override {
        if (!r.is_patch()) return at_point(r.center, r.normal);
        const double area = r.points.area(r.shape);
        if (length(front_) < area && is_before(r)) return mean_from_light(r) * length(front_) / area;
        double sum = 0.0;
        if (const SurfelPoints::Parallelogram* p = r.points.parallelogram(r.shape)) {
            for (std::size_t a = 0; a < rule_.at.size(); ++a)
                for (std::size_t b = 0; b < rule_.at.size(); ++b)
                    sum += rule_.weight[a] * rule_.weight[b] *
                           at_point(p->corner + rule_.at[a] * p->u + rule_.at[b] * p->v, r.normal);
            return sum;
        }
        EvenPoints even(2, 0, r.surfel);
        const int patch_points = r.is_whole_surfel ? points_of_patch : points_of_part;
        for (int k = 0; k < patch_points; ++k) {
            const double* u = even.next();
            sum += at_point(r.at(u[0], u[1]), r.normal);
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
    double at_point(const Vec3& point, const Vec3& normal) const {
        if (dot(point - light_.corner, front_) <= 0.0) return 0.0;
        const Vec3 corners[4] = {light_.corner, light_.corner + light_.edge_u,
                                 light_.corner + light_.edge_u + light_.edge_v, light_.corner + light_.edge_v};
        return element_to_polygon(point, normal, corners, 4);
    }
    const AreaLight& light_;
    Vec3 front_;
    struct {
        std::vector<double> at, weight;
    } rule_;
};

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

// Is the way free to a light at a place, or in a direction?
bool is_free(const Tracer& tracer, const Receiver& receiver, const Vec3& at, const Vec3& light, bool distant) {
    const Departure from{at, receiver.normal, receiver.surfel};
    return tracer.free(distant ? Ray{from, light} : segment(from, light));
}

using Part = NarrowLight::Part;

// Mean over the surfel of the irradiance from one light, per unit of its colour: the mean kernel times the share of it
// that gets through, by rays that count as much as passes along them.
Part irradiance_from(const Emitter& light, const Tracer& tracer, const Receiver& receiver, const DirectOptions& options,
                     EvenPoints even) {
    const double mean = light.mean_kernel(receiver);
    if (mean <= 0.0) return {};
    double all = 0.0, passed = 0.0;
    int taken = 0, lit = 0, dark = 0;
    thread_local std::vector<Triangle> lit_part;
    const ThreadScratch scratch(lit_part);
    if (receiver.is_patch()) light.find_lit(receiver, lit_part);
    double lit_area = 0.0;
    for (const Triangle& t : lit_part) lit_area += area_of(t);
    const auto point = [&](double s, double t) {
        if (!(lit_area > 0.0)) return receiver.at(s, t);
        const Triangle* part = lit_part.data();
        const Triangle* last = part + lit_part.size() - 1;
        for (s *= lit_area; part != last && s >= area_of(*part); ++part) s -= area_of(*part);
        const Vec3 w = square_to_triangle(std::min(s / area_of(*part), 1.0), t);
        return receiver.points.inset(receiver.shape, w.x * part->a + w.y * part->b + w.z * part->c);
    };
    const auto take = [&](int count) {
        for (; taken < count; ++taken) {
            const double* u = even.next();
            const Vec3 at = point(u[2], u[3]);
            const Arrival arrival = light.arrival(at, receiver.normal, u[0], u[1]);
            if (arrival.kernel <= 0.0) continue;
            const bool free = is_free(tracer, receiver, at, arrival.from, light.distant);
            all += arrival.kernel;
            if (free) passed += arrival.kernel;
            lit += free;
            dark += !free;
        }
    };
    take(light.extended || receiver.is_patch() ? options.probes : 1);
    // Where a single probe disagrees, it keeps its weight: it speaks for the surfels whose probes all missed the slit
    // that it found, too. More rays would take three quarters of it away, and of the light through narrow slits.
    const bool one_disagrees = (lit == 1 && dark > 1) || (dark == 1 && lit > 1);
    if (taken > 1 && lit > 0 && dark > 0 && !one_disagrees) take(options.rays);
    if (!(all > 0.0)) take(options.rays);  // a lamp that hardly rises over the horizon
    if (!(all > 0.0) && lit_part.empty()) return {};
    if (!(all > 0.0)) {
        // A hair of light at the rim of a spot, which no ray found: what of its surroundings sees the spot.
        const int probes = taken;
        for (int k = 0; k < probes; ++k) {
            const double* u = even.next();
            const Vec3 at = point(u[2], u[3]);
            const Arrival arrival = light.arrival(at, receiver.normal, u[0], u[1]);
            lit += is_free(tracer, receiver, at, arrival.from, light.distant);
        }
        return {mean * lit / probes, evenness * mean / std::sqrt(probes)};
    }
    const double share = passed / all;
    return {mean * share, evenness * mean * std::sqrt(share * (1.0 - share) / taken)};
}

}  // namespace

std::vector<Rgb> direct_irradiance(const Scene& scene, const Tracer& tracer, const DirectOptions& options,
                                   std::uint64_t seed, const Progress& progress) {
    return direct_irradiance(scene, tracer, SurfelPoints(scene.surfels), places_of(scene.surfels), options, seed,
                             progress);
}

std::vector<Rgb> direct_irradiance(const Scene& scene, const Tracer& tracer, const SurfelPoints& points,
                                   const std::vector<Place>& places, const DirectOptions& options, std::uint64_t seed,
                                   const Progress& progress, std::vector<Rgb>* errors) {
    const auto lights = emitters_of(scene.lights);
    std::vector<Rgb> direct(places.size());
    if (errors) errors->assign(places.size(), {});
    if (lights.empty()) return direct;
    // Disks, and those inserted in them, which have what the whole one has.
    const auto is_disk = [&](const Place& place) {
        return (place.is_whole_surfel() && !points.is_patch(place.shape)) ||
               (place.is_part && place.shape == Place::point);
    };
    const bool has_disks = std::any_of(places.begin(), places.end(), is_disk);
    const NarrowLight narrow = has_disks ? NarrowLight(scene, tracer, seed, progress) : NarrowLight();
    parallel_blocks(
        places.size(), 16,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) {
                const Place& place = places[k];
                const Receiver receiver{points,         place.surfel, place.shape,
                                        place.position, place.normal, place.is_whole_surfel()};
                Rgb squared;
                const bool as_disk = is_disk(place);
                for (std::size_t l = 0; l < lights.size(); ++l) {
                    const Part* whole = as_disk ? narrow.of(lights[l]->index, place.surfel) : nullptr;
                    const Part part = whole ? *whole
                                            : irradiance_from(*lights[l], tracer, receiver, options,
                                                              EvenPoints(4, seed + light_stream + l, stream_of(place)));
                    direct[k] += part.irradiance * lights[l]->color;
                    squared += (part.error * lights[l]->color) * (part.error * lights[l]->color);
                }
                if (errors) (*errors)[k] = {std::sqrt(squared.x), std::sqrt(squared.y), std::sqrt(squared.z)};
            }
        },
        progress);
    return direct;
}

}  // namespace surflux
